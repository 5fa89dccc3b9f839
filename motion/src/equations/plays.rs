//! What a play remembers from step to step. A signal that turns in between is the cubic with its values and rates at both ends
//! of the step.

use physics::number::Number;

use super::run::{At, Run};

/// A signal with its rate.
#[derive(Clone, Copy)]
pub(super) struct Signal<T> {
    value: T,
    rate: T,
}

impl<T: Number> Run<'_, T> {
    /// What plays follow, at the beginning of a step.
    pub fn plays_before(&mut self, t_s: f64, h: f64) -> Vec<Signal<T>> {
        if self.system.plays.is_empty() {
            return Vec::new();
        }
        self.enter(t_s + 0.5 * h);
        self.played(t_s)
    }

    /// The signals of all plays in the present states.
    fn played(&mut self, t_s: f64) -> Vec<Signal<T>> {
        self.rate(0, t_s, At::Before, false);
        self.routines.plays.run(&self.sides, &mut self.registers);
        let one = |k: usize| {
            let places = &self.routines.plays.rows[2 * k];
            let mut rate = T::from_f64(self.pace(places, t_s));
            for (state, place) in &places.states {
                rate += self.rates[0][*state] * self.registers[*place];
            }
            Signal { value: self.value(places, &self.states, t_s), rate }
        };
        (0..self.system.plays.len()).map(one).collect()
    }

    /// Moves the plays along a step of `h` seconds from `t_s` on, at whose beginning their signals were those `before`.
    pub fn play(&mut self, before: &[Signal<T>], t_s: f64, h: f64) {
        if before.is_empty() {
            return;
        }
        let after = self.played(t_s + h);
        for (k, (from, to)) in before.iter().zip(&after).enumerate() {
            let gap = self.value(&self.routines.plays.rows[2 * k + 1], &self.states, t_s + h);
            let state = self.system.plays[k].state;
            let turned =
                turn(from, to, h).map_or(self.states[state], |e| carried(self.states[state], e, gap));
            self.states[state] = carried(turned, to.value, gap);
        }
    }
}

/// A play that is carried along by a signal.
fn carried<T: Number>(play: T, signal: T, gap: T) -> T {
    let (lower, upper) = (signal - gap, signal + gap);
    if lower.value() > play.value() {
        lower
    } else if upper.value() < play.value() {
        upper
    } else {
        play
    }
}

/// The extreme of a signal in a step of `h` seconds, where it turns.
fn turn<T: Number>(from: &Signal<T>, to: &Signal<T>, h: f64) -> Option<T> {
    let (a, b) = (from.rate.value() * h, to.rate.value() * h);
    if a * b >= 0.0 {
        return None;
    }
    // The root of the cubic's rate a + 2 (3 rise − 2 a − b) s + 3 (a + b − 2 rise) s² that lies between the ends.
    let rise = to.value.value() - from.value.value();
    let (half, square) = (3.0 * rise - 2.0 * a - b, 3.0 * (a + b - 2.0 * rise));
    let root = (half * half - square * a).max(0.0).sqrt();
    let sum = -(half + half.signum() * root);
    let s = [sum / square, a / sum].into_iter().find(|s| (0.0..=1.0).contains(s))?;
    let rest = 1.0 - s;
    // The extreme moves with the ends; where it lies does not matter, since the rate there is zero.
    Some(
        from.value * (rest * rest * (1.0 + 2.0 * s))
            + from.rate * (h * s * rest * rest)
            + to.value * (s * s * (3.0 - 2.0 * s))
            + to.rate * (-h * s * s * rest),
    )
}
