//! What acts between the driven frame, which carries the pads, and the mirror: lost motion.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::device::Device;
use crate::orthogonal;
use crate::units::rad_from_arcsec;

/// θ − play_r(θ): the mirror stays where it is until the frame has taken up the play.
pub(super) const BACKLASH: Specification = Specification {
    id: "backlash",
    title: "lost motion between frame and mirror",
    scope: Scope::Device,
    depends_on: &["direction", "history"],
    parameters: &[Parameter::needed("half_width_arcsec", "arcsec", (0.0, 1e3), Drawn::PositiveStrength)],
    build: |values, _| Ok(Box::new(Play::new(rad_from_arcsec(values["half_width_arcsec"])))),
};

/// The play operator: an output that a gap drags along.
#[derive(Clone)]
struct Play {
    half_width_rad: f64,
    output_rad: f64,
}

impl Play {
    /// At rest in the middle of its gap.
    fn new(half_width_rad: f64) -> Self {
        Self { half_width_rad, output_rad: 0.0 }
    }

    /// The output if the input ran straight to `input_rad`.
    fn output_rad(&self, input_rad: f64) -> f64 {
        self.output_rad.clamp(input_rad - self.half_width_rad, input_rad + self.half_width_rad)
    }

    /// How far the input would then stand ahead.
    fn ahead_rad(&self, input_rad: f64) -> f64 {
        input_rad - self.output_rad(input_rad)
    }

    /// The input has run to `input_rad`.
    fn moved(&mut self, input_rad: f64) {
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

/// A distributed play over the stroke: the mirror hangs on the frame by an adhesive with inner friction, many small
/// elements of which each slips at its own deflection (Prandtl–Ishlinskii).
///
/// With equal weight at all radii the loop is the lens of Rayleigh's law; `skew` gives the radii a weight
/// that grows as their power. The elements are scaled so that the steady loop over the stroke departs from
/// its own least-squares polynomial of order 9 in the angle by `half_height_arcsec` at most.
pub(super) const HYSTERESIS: Specification = Specification {
    id: "hysteresis",
    title: "inner friction between frame and mirror",
    scope: Scope::Device,
    depends_on: &["direction", "history"],
    parameters: &[
        Parameter::needed("half_height_arcsec", "arcsec", (0.0, 1e3), Drawn::PositiveStrength),
        Parameter::needed("skew", "1", (-0.9, 4.0), Drawn::Uniform(0.0, 0.0)).or(0.0),
    ],
    build: |values, device| {
        let unit = Elements::new(values["skew"], device);
        let height_rad = unit.half_height_rad(device);
        let factor = rad_from_arcsec(values["half_height_arcsec"]) / height_rad;
        Ok(Box::new(Elements { weights: unit.weights.iter().map(|w| w * factor).collect(), ..unit }))
    },
};

/// Enough elements that none shows as a corner.
const ELEMENTS: usize = 48;

#[derive(Clone)]
struct Elements {
    plays: Vec<Play>,
    weights: Vec<f64>,
}

impl Elements {
    /// Elements whose radii fill half the stroke, of total weight 1.
    fn new(skew: f64, device: &Device) -> Self {
        let [first, last] = device.stroke_rad();
        let parts: Vec<f64> = (0..ELEMENTS).map(|i| (i as f64 + 0.5) / ELEMENTS as f64).collect();
        let total: f64 = parts.iter().map(|part| part.powf(skew)).sum();
        Self {
            plays: parts.iter().map(|part| Play::new(0.5 * (last - first) * part)).collect(),
            weights: parts.iter().map(|part| part.powf(skew) / total).collect(),
        }
    }

    fn ahead_rad(&self, frame_rad: f64) -> f64 {
        self.plays.iter().zip(&self.weights).map(|(play, weight)| weight * play.ahead_rad(frame_rad)).sum()
    }

    /// The largest distance of the steady loop over the stroke from its polynomial of order 9.
    fn half_height_rad(&self, device: &Device) -> f64 {
        let mut elements = self.clone();
        let [first, last] = device.stroke_rad();
        let steps = 68;
        let at = |i: i32| first + (last - first) * f64::from(i) / f64::from(steps);
        let cycle: Vec<f64> = (0..=steps).map(at).chain((0..=steps).rev().map(at)).collect();
        let mut ahead = Vec::new();
        for round in 0..2 {
            for &angle in &cycle {
                elements.plays.iter_mut().for_each(|play| play.moved(angle));
                if round == 1 {
                    ahead.push(elements.ahead_rad(angle));
                }
            }
        }
        orthogonal::residual(&cycle, &ahead, 9).iter().fold(0.0, |most, r| r.abs().max(most))
    }
}

impl Mechanism for Elements {
    fn lost_motion_rad(&self, frame_rad: f64) -> f64 {
        self.ahead_rad(frame_rad)
    }

    fn settled(&mut self, pose: &Pose) {
        self.plays.iter_mut().for_each(|play| play.moved(pose.frame_rad));
    }
}
