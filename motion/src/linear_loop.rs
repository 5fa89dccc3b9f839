//! Hysteresis inside a linear plant: what an actuator's domains add between the states of its structure.
//! For every loop l a signal ζ_l = C_l z + D_l u moves a bank of plays (backlash elements), and their
//! weighted sum w_l acts on the states and the positions. Uniform weights make it Rayleigh's hysteresis.

use fitter::plant::{Numbers, PlantEffect};

/// The loops of a plant: matrices by rows, and the plays, one bank per loop.
#[derive(Debug, Clone, Default)]
pub struct Loops {
    into_state: Vec<f64>,
    into_position: Vec<f64>,
    from_state: Vec<f64>,
    from_drive: Vec<f64>,
    thresholds: Vec<f64>,
    weights: Vec<f64>,
    count: usize,
    plays: Vec<f64>,
}

/// Whether an effect is a loop, not one on the way of the drives.
pub fn is_loop(effect: &PlantEffect) -> bool {
    effect.id == "rayleigh_hysteresis" && effect.parameters.contains_key("into_state")
}

/// Inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Loops {
    /// The loops that a plant of so many states, drives and positions has among its effects; the name of the
    /// parameter that is missing or of another length where they do not fit.
    pub fn of(
        effects: &[PlantEffect],
        states: usize,
        drives: usize,
        positions: usize,
    ) -> Result<Loops, String> {
        let Some(effect) = effects.iter().find(|effect| is_loop(effect)) else {
            return Ok(Loops::default());
        };
        let list = |name: &str| match effect.parameters.get(name) {
            Some(Numbers::Each(values)) => Ok(values.clone()),
            _ => Err(format!("`{name}` is missing or no list")),
        };
        let from_drive = list("from_drive")?;
        let count = from_drive.len() / drives.max(1);
        let (thresholds, weights) = (list("thresholds")?, list("weights")?);
        let sized = |name: &str, expected: usize| {
            let values = list(name)?;
            let found = values.len();
            if found == expected {
                Ok(values)
            } else {
                Err(format!("`{name}` has {found} numbers, expected {expected}"))
            }
        };
        let (into_state, into_position) =
            (sized("into_state", states * count)?, sized("into_position", positions * count)?);
        let from_state = sized("from_state", count * states)?;
        sized("from_drive", count * drives)?;
        sized("weights", thresholds.len())?;
        let plays = vec![0.0; count * thresholds.len()];
        Ok(Loops { into_state, into_position, from_state, from_drive, thresholds, weights, count, plays })
    }

    /// w at the states `z` and the drives `u`; the plays move.
    pub fn output(&mut self, z: &[f64], u: &[f64]) -> Vec<f64> {
        let bank = self.thresholds.len();
        (0..self.count)
            .map(|l| {
                let signal = dot(&self.from_state[l * z.len()..(l + 1) * z.len()], z)
                    + dot(&self.from_drive[l * u.len()..(l + 1) * u.len()], u);
                let plays = &mut self.plays[l * bank..(l + 1) * bank];
                for (play, half_width) in plays.iter_mut().zip(&self.thresholds) {
                    *play = play.min(signal + half_width).max(signal - half_width);
                }
                dot(plays, &self.weights)
            })
            .collect()
    }

    /// What w adds to state `index` at the next sample.
    pub fn adds_to_state(&self, index: usize, w: &[f64]) -> f64 {
        self.adds(&self.into_state, index, w)
    }

    /// What w adds to position `index`.
    pub fn adds_to_position(&self, index: usize, w: &[f64]) -> f64 {
        self.adds(&self.into_position, index, w)
    }

    fn adds(&self, into: &[f64], index: usize, w: &[f64]) -> f64 {
        let row = &into[index * self.count..(index + 1) * self.count];
        row.iter().zip(w).fold(0.0, |sum, (e, w)| sum + e * w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effect(weights: usize) -> PlantEffect {
        let each = |values: Vec<f64>| Numbers::Each(values);
        let parameters = [
            ("into_state", each(vec![0.5])),
            ("into_position", each(vec![2.0])),
            ("from_state", each(vec![0.0])),
            ("from_drive", each(vec![1.0])),
            ("thresholds", each((0..100).map(|k| (k as f64 + 0.5) / 100.0).collect())),
            ("weights", each(vec![0.01; weights])),
        ];
        PlantEffect {
            id: "rayleigh_hysteresis".into(),
            parameters: parameters.into_iter().map(|(name, value)| (name.to_string(), value)).collect(),
        }
    }

    #[test]
    fn uniform_plays_follow_rayleighs_law() {
        let mut loops = Loops::of(&[effect(100)], 1, 1, 1).unwrap();
        let top = loops.output(&[0.0], &[0.8])[0];
        assert!((top - 0.32).abs() < 1e-3, "virgin curve u²/2: {top}");
        let down = loops.output(&[0.0], &[-0.2])[0];
        assert!((top - down - 0.25).abs() < 1e-3, "from a reversal Δu²/4: {}", top - down);
        assert!((loops.adds_to_position(0, &[down]) - 2.0 * down).abs() < 1e-15);
    }

    #[test]
    fn matrices_of_another_size_are_refused() {
        assert!(Loops::of(&[effect(99)], 1, 1, 1).unwrap_err().contains("weights"));
        assert!(Loops::of(&[effect(100)], 2, 1, 1).unwrap_err().contains("into_state"));
    }
}
