//! Hysteresis, a distributed play over the stroke: the mirror hangs on the frame by an adhesive with inner
//! friction, many small elements of which each slips at its own deflection (Prandtl–Ishlinskii).
//!
//! With equal weight at all radii the loop is the lens of Rayleigh's law; `skew` gives the radii a weight
//! that grows as their power. The elements are scaled so that the steady loop over the stroke departs from
//! its own least-squares polynomial of order 9 in the angle by `half_height_arcsec` at most.

use super::backlash::Play;
use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::device::Device;
use crate::orthogonal;
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "hysteresis",
    title: "inner friction between frame and mirror",
    scope: Scope::Device,
    depends_on: &["direction", "history"],
    times: Some("angle_deg"),
    parameters: &[
        Parameter {
            name: "half_height_arcsec",
            unit: "arcsec",
            default: None,
            range: (0.0, 1e3),
            drawn: Drawn::PositiveStrength,
        },
        Parameter {
            name: "skew",
            unit: "1",
            default: Some(0.0),
            range: (-0.9, 4.0),
            drawn: Drawn::Uniform(0.0, 0.0),
        },
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

#[derive(Debug, Clone)]
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
