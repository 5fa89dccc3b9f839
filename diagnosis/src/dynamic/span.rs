//! The drive in one step of the integrator: a parabola.

use physics::number::Number;

use super::lag::moments;
use super::turns::Turns;

/// The drive at the beginning, middle and end of a step.
#[derive(Clone, Copy)]
pub struct Span<T> {
    /// At the beginning.
    pub from: T,
    /// In the middle.
    pub middle: T,
    /// At the end.
    pub to: T,
}

impl<T: Number> Span<T> {
    /// The drive at a part of the step, on the parabola through the three.
    pub fn at(&self, s: T) -> T {
        let rise = self.to - self.from;
        let bend = (self.from + self.to - self.middle * 2.0) * 2.0;
        self.from + s * rise - s * (T::from_f64(1.0) - s) * bend
    }

    /// The part of it from `s` on.
    pub fn rest(&self, s: T) -> Span<T> {
        let half = (s + T::from_f64(1.0)) * 0.5;
        Span { from: self.at(s), middle: self.at(half), to: self.to }
    }

    /// The response of a hysteresis to it, which has to see where the drive turns round in between.
    pub fn remembered(&self, turns: &mut Turns<T>) -> Span<T> {
        let (from, middle, to) = (self.from.value(), self.middle.value(), self.to.value());
        let (rise, bend) = (to - from, 2.0 * (from + to - 2.0 * middle));
        let vertex = 0.5 * (1.0 - rise / bend);
        let turn = |inside: bool, turns: &mut Turns<T>| {
            if inside {
                turns.to(self.at(T::from_f64(vertex)));
            }
        };
        let from = turns.to(self.from);
        turn(vertex > 0.0 && vertex < 0.5, turns);
        let middle = turns.to(self.middle);
        turn(vertex > 0.5 && vertex < 1.0, turns);
        Span { from, middle, to: turns.to(self.to) }
    }

    /// It and so much of another one.
    pub fn plus(&self, part: T, other: &Span<T>) -> Span<T> {
        Span {
            from: self.from + part * other.from,
            middle: self.middle + part * other.middle,
            to: self.to + part * other.to,
        }
    }

    /// The parabola with the moments ∫ w ds, ∫ s w ds and ∫ s² w ds.
    pub fn of_moments([m0, m1, m2]: [T; 3]) -> Span<T> {
        Span {
            from: m0 * 9.0 - m1 * 36.0 + m2 * 30.0,
            middle: (m1 - m2) * 15.0 - m0 * 1.5,
            to: m0 * 3.0 - m1 * 24.0 + m2 * 30.0,
        }
    }

    /// Those of the parabola.
    pub fn moments(&self) -> [T; 3] {
        let (a, b) = (self.from, self.middle * 4.0 - self.from * 3.0 - self.to);
        moments([a, b, (self.from + self.to - self.middle * 2.0) * 2.0, T::from_f64(0.0)])
    }

    /// The part of it up to `s`.
    pub fn up_to(&self, s: T) -> Span<T> {
        Span { from: self.from, middle: self.at(s * 0.5), to: self.at(s) }
    }
}
