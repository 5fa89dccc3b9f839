//! Backlash, θ − play_r(θ): lost motion between the driven frame, which carries the pads, and the mirror.
//! The mirror stays where it is until the frame has taken up the play.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "backlash",
    title: "lost motion between frame and mirror",
    scope: Scope::Device,
    depends_on: &["direction", "history"],
    times: None,
    parameters: &[Parameter {
        name: "half_width_arcsec",
        unit: "arcsec",
        default: None,
        range: (0.0, 1e3),
        drawn: Drawn::PositiveStrength,
    }],
    build: |values, _| Ok(Box::new(Play::new(rad_from_arcsec(values["half_width_arcsec"])))),
};

/// The play operator: an output that a gap drags along.
#[derive(Debug, Clone)]
pub(super) struct Play {
    half_width_rad: f64,
    output_rad: f64,
}

impl Play {
    /// At rest in the middle of its gap.
    pub(super) fn new(half_width_rad: f64) -> Self {
        Self { half_width_rad, output_rad: 0.0 }
    }

    /// The output if the input ran straight to `input_rad`.
    fn output_rad(&self, input_rad: f64) -> f64 {
        self.output_rad.clamp(input_rad - self.half_width_rad, input_rad + self.half_width_rad)
    }

    /// How far the input would then stand ahead.
    pub(super) fn ahead_rad(&self, input_rad: f64) -> f64 {
        input_rad - self.output_rad(input_rad)
    }

    /// The input has run to `input_rad`.
    pub(super) fn moved(&mut self, input_rad: f64) {
        self.output_rad = self.output_rad(input_rad);
    }
}

impl Mechanism for Play {
    fn lost_motion_rad(&self, frame_rad: f64) -> f64 {
        self.ahead_rad(frame_rad)
    }

    fn settled(&mut self, pose: &Pose) {
        self.moved(pose.frame_rad);
    }
}
