//! Hysteresis after Rayleigh, of a piezo or of iron at low fields: w = u + c·R(u), where R = u·|u| on the
//! virgin curve and R = R_r + ½(u − u_r)·|u − u_r| from the last reversal (u_r, R_r). A branch that comes
//! back to an earlier reversal goes on along the branch that it left there (return-point memory, Madelung's
//! rules).
//!
//! Gain and loss grow with the amplitude: at the amplitude A the gain is 1 + c·A and the loop has the half
//! width c·A²/2.

use super::specification::ANY;
use super::{Action, Element, Parameter, Specification};
use crate::signal::Flow;

pub const SPECIFICATION: Specification = Specification {
    id: "rayleigh_hysteresis",
    title: "hysteresis of a piezo that grows with the amplitude",
    depends_on: &["amplitude", "history", "drive"],
    parameters: &[Parameter::needed("coefficient", "1/drive unit", ANY)],
    build: |values, _| {
        Action::Drive(Box::new(Domains { coefficient: values["coefficient"], ..Domains::default() }))
    },
    draw: |strength, typical, _| vec![("coefficient", strength / typical.drive)],
};

#[derive(Debug, Clone, Default)]
struct Domains {
    coefficient: f64,
    /// Reversals (u, R) that are not closed yet, the oldest and widest first; they alternate.
    reversals: Vec<(f64, f64)>,
    /// Where the input is, and R there.
    here: (f64, f64),
}

impl Domains {
    /// How many reversals are left when the input moves from `here` to `u`, and whether `here` has become one.
    fn branch(&self, u: f64) -> (usize, bool) {
        let (now, _) = self.here;
        let upwards = u > now;
        let from = self.reversals.last().map_or(0.0, |reversal| reversal.0);
        let turned = u != now && now != from && upwards != (now > from);
        // The open reversals, the one at `here` among them, of which a monotone move closes two at a time.
        let mut open = self.reversals.len() + usize::from(turned);
        let at = |index: usize| self.reversals.get(index).map_or(now, |reversal| reversal.0);
        loop {
            // What the move has to pass to close the branch that it is on: the reversal before, or, where
            // there is none, the mirror image of the only one, where the virgin curve goes on.
            let target = match open {
                0 => break,
                1 => -at(0),
                _ => at(open - 2),
            };
            if (upwards && u < target) || (!upwards && u > target) || u == now {
                break;
            }
            open = open.saturating_sub(2);
        }
        (open, turned && open == self.reversals.len() + 1)
    }

    /// R at `u`, and dR/du.
    fn response(&self, u: f64) -> (f64, f64) {
        let (open, turned) = self.branch(u);
        if open == 0 {
            return (u * u.abs(), 2.0 * u.abs());
        }
        let (from, response) = if turned { self.here } else { self.reversals[open - 1] };
        let moved = u - from;
        (response + 0.5 * moved * moved.abs(), moved.abs())
    }
}

impl Element for Domains {
    fn pass(&self, _: f64, drive: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        let (response, slope) = self.response(drive.value);
        Flow {
            value: drive.value + self.coefficient * response,
            rate: drive.rate * (1.0 + self.coefficient * slope),
        }
    }

    fn remembers_turns(&self) -> bool {
        true
    }

    fn remember(&mut self, input: f64) {
        let response = self.response(input).0;
        let (open, turned) = self.branch(input);
        if turned {
            self.reversals.push(self.here);
        }
        self.reversals.truncate(open);
        self.here = (input, response);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(inputs: &[f64]) -> Domains {
        let mut domains = Domains { coefficient: 1.0, ..Domains::default() };
        inputs.iter().for_each(|&u| domains.remember(u));
        domains
    }

    #[test]
    fn virgin_curve_loop_and_return_point() {
        assert_eq!(along(&[0.5, 1.0]).here.1, 1.0);
        // The lens of Rayleigh: from the tip at 1, R falls by half the square of the way.
        assert_eq!(along(&[1.0, 0.0]).here.1, 0.5);
        assert_eq!(along(&[1.0, 0.0, -1.0]).here.1, -1.0);
        // A small loop inside closes where it was left and is forgotten.
        let closed = along(&[1.0, -0.5, 0.2, -0.5, -0.7]);
        let straight = along(&[1.0, -0.7]);
        assert!((closed.here.1 - straight.here.1).abs() < 1e-15);
        assert_eq!(closed.reversals.len(), 1);
        // Beyond the widest reversal the virgin curve goes on.
        assert_eq!(along(&[1.0, -0.5, 1.5]).here.1, 2.25);
        assert_eq!(along(&[1.0, -1.5]).here.1, -2.25);
        assert!(along(&[1.0, -0.5, 1.5]).reversals.is_empty());
    }

    /// Rayleigh's material is a continuum of plays of equal density: R = 2 ∫ play_r(u) dr.
    #[test]
    fn a_continuum_of_plays_is_the_same() {
        let step = 1e-4;
        let mut plays = vec![0.0f64; 30_000];
        let mut domains = Domains { coefficient: 1.0, ..Domains::default() };
        let mut seed = 1u64;
        for _ in 0..40 {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let u = 4.0 * ((seed >> 11) as f64 / (1u64 << 53) as f64) - 2.0;
            domains.remember(u);
            for (index, play) in plays.iter_mut().enumerate() {
                let r = step * (index as f64 + 0.5);
                *play = play.clamp(u - r, u + r);
            }
            let sum: f64 = 2.0 * step * plays.iter().sum::<f64>();
            assert!((sum - domains.here.1).abs() < 1e-6, "{sum} {:?}", domains.here);
        }
    }
}
