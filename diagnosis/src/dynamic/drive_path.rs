//! The path of the drive to the mechanism: delay, offset, saturation, lag, hysteresis. What reaches the mechanism
//! in one step of the integrator is handed on as the parabola with the same mean, first and second moment: the
//! fourth-order rule then moves the mechanism as the drive itself would, jumps and fast transients included.

use physics::number::Number;

use super::effects::Part;
use super::lag::{Lag, moments};
use super::model::Model;
use super::signal::{Piece, Signal};
use super::simulate::{Course, Theta};
use super::span::Span;
use super::turns::Turns;
use crate::thresholds::dynamic::drive_path::LEAST_PART;

/// The drive's path.
pub struct DrivePath<'a, T> {
    model: &'a Model,
    theta: &'a Theta<T>,
    signal: &'a Signal,
    delay: Option<T>,
    /// Terms that change the drive without memory, in their order.
    shaping: Vec<usize>,
    /// Time constant and state.
    lag: Option<(T, Lag<T>)>,
    /// Coefficient and what is remembered.
    memory: Option<(T, Turns<T>)>,
}

impl<'a, T: Number> DrivePath<'a, T> {
    /// The path of a model's drive from interval `first` on.
    pub fn new(model: &'a Model, theta: &'a Theta<T>, course: &Course<'a>, first: isize) -> DrivePath<'a, T> {
        let parameter = |part: Part| model.acting(part).map(|k| theta.terms[k][0]);
        // An offset comes before a limit, whichever was found first.
        let mut shaping: Vec<usize> = model.acting(Part::Drive).collect();
        shaping.sort_by_key(|k| model.terms[*k].effect.is_limit());
        let delay = parameter(Part::Delay).reduce(|a, b| a + b);
        let mut path =
            DrivePath { model, theta, signal: course.signal, delay, shaping, lag: None, memory: None };
        path.lag = parameter(Part::DriveLag).next().map(|tau| {
            let [input, rise, ..] =
                path.pieces(first, 0.0, 1.0)[0].map_or([tau; 4], |p| path.shaped(p.cubic));
            (tau, Lag::behind(input, rise * (1.0 / course.step_s), tau))
        });
        path.memory = parameter(Part::DriveMemory).next().map(|coefficient| {
            let mut turns = Turns::new();
            course.before.iter().for_each(|u| {
                turns.to(path.shape(T::from_f64(*u)));
            });
            (coefficient, turns)
        });
        path
    }

    /// What reaches the mechanism in the part of interval `k` from `s` on, which takes `time`.
    #[inline]
    pub fn span(&mut self, k: isize, s: f64, part: f64, time: f64) -> Span<T> {
        if self.delay.is_none() && self.lag.is_none() {
            let [a, b, c, d] = self.signal.piece(k, s, part);
            let at = |r: f64| self.shape(T::from_f64(a + r * (b + r * (c + r * d))));
            let span = Span { from: at(0.0), middle: at(0.5), to: at(1.0) };
            return match &mut self.memory {
                None => span,
                Some((coefficient, turns)) => span.remembered(*coefficient, turns),
            };
        }
        let mut sums = [T::from_f64(0.0); 3];
        let mut passed = T::from_f64(0.0);
        for piece in self.pieces(k, s, part).into_iter().flatten() {
            let length = piece.part;
            if length.value() < LEAST_PART {
                continue;
            }
            let cubic = self.shaped(piece.cubic);
            let [m0, m1, m2] = self.passed(cubic, length * time);
            sums[0] += length * m0;
            sums[1] += length * (passed * m0 + length * m1);
            sums[2] += length * (passed * passed * m0 + length * (passed * m1 * 2.0 + length * m2));
            passed += length;
        }
        Span::of_moments(sums)
    }

    /// The stretches of the recorded drive, in their order.
    fn pieces(&self, k: isize, s: f64, part: f64) -> [Option<Piece<T>>; 2] {
        match self.delay {
            Some(delay) => self.signal.delayed(k, s, part, delay),
            None => {
                let cubic = self.signal.piece(k, s, part).map(T::from_f64);
                [Some(Piece { cubic, part: T::from_f64(1.0) }), None]
            }
        }
    }

    /// What does not remember.
    #[inline]
    fn shape(&self, mut drive: T) -> T {
        for k in &self.shaping {
            self.model.terms[*k].effect.law.drive(&self.theta.terms[*k], &mut drive);
        }
        drive
    }

    /// The same along a stretch: exact where the drive stands, else the cubic through four points.
    fn shaped(&self, cubic: [T; 4]) -> [T; 4] {
        if self.shaping.is_empty() {
            return cubic;
        }
        let [a, b, c, d] = cubic;
        if [b, c, d].iter().all(|x| x.value() == 0.0) {
            return [self.shape(a), b, c, d];
        }
        let at = |r: f64| self.shape(a + (b + (c + d * r) * r) * r);
        let [f0, f1, f2, f3] = [at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0)];
        [
            f0,
            (f1 * 18.0 - f0 * 11.0 - f2 * 9.0 + f3 * 2.0) * 0.5,
            (f0 * 18.0 - f1 * 45.0 + f2 * 36.0 - f3 * 9.0) * 0.5,
            (f1 * 27.0 - f0 * 9.0 - f2 * 27.0 + f3 * 9.0) * 0.5,
        ]
    }

    /// Moments of what a stretch becomes through lag and hysteresis.
    fn passed(&mut self, cubic: [T; 4], time: T) -> [T; 3] {
        let Some((coefficient, turns)) = &mut self.memory else {
            return match &mut self.lag {
                Some((tau, lag)) => lag.pass(cubic, time, *tau),
                None => moments(cubic),
            };
        };
        let [a, b, c, d] = cubic;
        let span = match &mut self.lag {
            Some((tau, lag)) => Span {
                from: lag.state,
                middle: lag.half_way(cubic, time, *tau),
                to: lag.advance(cubic, time, *tau),
            },
            None => Span { from: a, middle: a + b * 0.5 + c * 0.25 + d * 0.125, to: a + b + c + d },
        };
        span.remembered(*coefficient, turns).moments()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::effects::effect;
    use crate::dynamic::model::Term;
    use fitter::plant::Hold;

    /// A jump of a held drive arrives in the middle of a step after a delay, and the mean of the step has it.
    #[test]
    fn a_delayed_jump_has_its_moments() {
        let drive = [0.0, 0.0, 1.0, 1.0, 1.0];
        let signal = Signal::new(&drive, 0, 1e-3, Hold::ZeroOrder);
        let course = Course {
            signal: &signal,
            step_s: 1e-3,
            rows: 5,
            start_s: 0.0,
            bound: 1.0,
            before: &[],
            lead: &[],
        };
        let delay = Term::new(effect("transport_delay").unwrap(), vec![0.3e-3]);
        let model = Model::nominal([1.0, 1.0, 1.0], Hold::ZeroOrder).with(delay);
        let theta = Theta::plain(&model);
        let mut path = DrivePath::new(&model, &theta, &course, 0);
        let [m0, m1, m2] = path.span(2, 0.0, 1.0, 1e-3).moments();
        assert!((m0 - 0.7).abs() < 1e-12);
        assert!((m1 - 0.5 * (1.0 - 0.09)).abs() < 1e-12);
        assert!((m2 - (1.0 - 0.027) / 3.0).abs() < 1e-12);
    }
}
