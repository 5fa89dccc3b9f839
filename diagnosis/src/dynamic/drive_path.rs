//! The path of the drive to the mechanism: delay, offset, saturation, lag, hysteresis. What reaches the mechanism
//! in one step of the integrator is handed on as the parabola with the same mean, first and second moment: the
//! fourth-order rule then moves the mechanism as the drive itself would, jumps and fast transients included.

use std::ops::Mul;

use physics::number::Number;

use super::amplifier::Amplifier;
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
    signal: &'a Signal,
    delay: Option<T>,
    amplifier: Amplifier<T>,
    lag: Option<Lag<T>>,
    /// Coefficient and what is remembered.
    memory: Option<(T, Turns<T>)>,
}

impl<'a, T: Number> DrivePath<'a, T> {
    /// The path of a model's drive from interval `first` on.
    pub fn new(model: &'a Model, theta: &'a Theta<T>, course: &Course<'a>, first: isize) -> DrivePath<'a, T> {
        let parameter = |part: Part| model.acting(part).map(|k| theta.terms[k][0]);
        let acting = |limits: bool| {
            let terms =
                model.acting(Part::Drive).filter(move |k| model.terms[*k].effect.is_limit() == limits);
            terms.map(|k| theta.terms[k][0])
        };
        let narrower = |a: T, b: T| if b.value() < a.value() { b } else { a };
        let amplifier =
            Amplifier { offset: acting(false).reduce(|a, b| a + b), limit: acting(true).reduce(narrower) };
        let delay = parameter(Part::Delay).reduce(|a, b| a + b);
        let mut path = DrivePath { signal: course.signal, delay, amplifier, lag: None, memory: None };
        path.lag = parameter(Part::DriveLag).next().map(|tau| {
            let mut pieces =
                path.signal.pieces(first, 0.0, 1.0, delay).flat_map(|piece| amplifier.parts(piece, |x| x));
            let begins = pieces.find(|(_, part)| part.value() >= LEAST_PART);
            let [input, rise] =
                begins.map_or([T::from_f64(0.0); 2], |([input, rise, ..], part)| [input, rise / part]);
            Lag::behind(input, rise * (1.0 / course.step_s), tau, course.step_s)
        });
        path.memory = parameter(Part::DriveMemory).next().map(|coefficient| {
            let mut turns = Turns::new();
            course.before.iter().for_each(|u| {
                turns.to(amplifier.pass(T::from_f64(*u)));
            });
            (coefficient, turns)
        });
        path
    }

    /// What reaches the mechanism in the part of interval `k` from `s` on, which takes `time`.
    #[inline]
    pub fn span(&mut self, k: isize, s: f64, part: f64, time: f64) -> Span<T> {
        let unbent = |cubic: &[f64; 4]| self.amplifier.limit.is_none() || cubic[1..] == [0.0; 3];
        let at_once = |cubic: &[f64; 4]| self.delay.is_none() && self.lag.is_none() && unbent(cubic);
        if let Some([a, b, c, d]) = self.signal.whole(k, s, part).filter(at_once) {
            let at = |r: f64| self.amplifier.pass(T::from_f64(a + r * (b + r * (c + r * d))));
            let span = Span { from: at(0.0), middle: at(0.5), to: at(1.0) };
            return match &mut self.memory {
                None => span,
                Some((coefficient, turns)) => span.plus(*coefficient, &span.remembered(turns)),
            };
        }
        if let Some(span) = self.open(k, s, part) {
            return span;
        }
        // Only a delay gives the pieces' lengths derivatives.
        match self.delay {
            None => self.through(self.signal.pieces(k, s, part, None), time, T::from_f64),
            Some(_) => self.through(self.signal.pieces(k, s, part, self.delay), time, |x| x),
        }
    }

    /// What reaches the mechanism where at most an offset changes the drive: numbers without derivatives do.
    fn open(&self, k: isize, s: f64, part: f64) -> Option<Span<T>> {
        if self.delay.is_some() || self.lag.is_some() || self.memory.is_some() {
            return None;
        }
        let (mut sums, mut passed) = ([0.0; 3], 0.0);
        for Piece { cubic, part: length } in self.signal.pieces::<f64>(k, s, part, None) {
            if !self.amplifier.is_open(cubic) {
                return None;
            }
            add(&mut sums, moments(cubic), passed, length);
            passed += length;
        }
        let Span { from, middle, to } = Span::of_moments(sums);
        let behind = |drive: f64| {
            self.amplifier.offset.map_or(T::from_f64(drive), |offset| offset + T::from_f64(drive))
        };
        Some(Span { from: behind(from), middle: behind(middle), to: behind(to) })
    }

    /// What reaches the mechanism along some pieces of the drive, in their order.
    #[inline(always)]
    fn through<L: Number>(
        &mut self,
        pieces: impl Iterator<Item = Piece<L>>,
        time: f64,
        lift: impl Fn(L) -> T + Copy,
    ) -> Span<T>
    where
        T: Mul<L, Output = T>,
    {
        let amplifier = self.amplifier;
        let mut sums = [T::from_f64(0.0); 3];
        let mut passed = L::from_f64(0.0);
        for piece in pieces {
            for (cubic, length) in amplifier.parts(piece, lift) {
                let moments = match length.value() < LEAST_PART {
                    true => self.begun(cubic[0], lift(length * time)),
                    false => self.passed(cubic, lift(length * time)),
                };
                add(&mut sums, moments, passed, length);
                passed += length;
            }
        }
        Span::of_moments(sums)
    }

    /// Moments of a stretch that has no length but derivatives, behind the lag. What a hysteresis adds to these derivatives is left
    /// out: they only say where a fit goes from a delay of whole steps.
    fn begun(&mut self, drive: T, time: T) -> [T; 3] {
        let reached = match &mut self.lag {
            Some(lag) => {
                lag.begin(drive, time);
                lag.state
            }
            None => drive,
        };
        moments([reached, T::from_f64(0.0), T::from_f64(0.0), T::from_f64(0.0)])
    }

    /// Moments of any other stretch behind lag and hysteresis: exact but for the response of the hysteresis.
    fn passed(&mut self, cubic: [T; 4], time: T) -> [T; 3] {
        let [a, b, c, d] = cubic;
        // The lag's transient takes an exponential, which nothing else needs half-way.
        let seen = self.memory.is_some().then(|| match &mut self.lag {
            Some(lag) => [lag.state, lag.half_way(cubic, time)],
            None => [a, a + b * 0.5 + c * 0.25 + d * 0.125],
        });
        let (mut passed, to) = match &mut self.lag {
            Some(lag) => (lag.pass(cubic, time), lag.state),
            None => (moments(cubic), a + b + c + d),
        };
        if let (Some((coefficient, turns)), Some([from, middle])) = (&mut self.memory, seen) {
            let response = Span { from, middle, to }.remembered(turns).moments();
            passed.iter_mut().zip(response).for_each(|(moment, more)| *moment += *coefficient * more);
        }
        passed
    }
}

/// Adds a piece's moments to those of the step, of which a part has passed.
#[inline(always)]
fn add<T: Number + Mul<L, Output = T>, L: Number>(
    sums: &mut [T; 3],
    [m0, m1, m2]: [T; 3],
    passed: L,
    length: L,
) {
    sums[0] += m0 * length;
    sums[1] += (m0 * passed + m1 * length) * length;
    sums[2] += (m0 * (passed * passed) + (m1 * passed * 2.0 + m2 * length) * length) * length;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::effects::effect;
    use crate::dynamic::model::Term;
    use fitter::plant::Hold;

    /// Moments of the first four steps along a held drive that jumps to 1 at the third.
    fn along_a_jump(model: &Model) -> Vec<[f64; 3]> {
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
        let theta = Theta::plain(model);
        let mut path = DrivePath::new(model, &theta, &course, 0);
        (0..4).map(|k| path.span(k, 0.0, 1.0, 1e-3).moments()).collect()
    }

    /// A jump of a held drive arrives in the middle of a step after a delay, and the mean of the step has it.
    #[test]
    fn a_delayed_jump_has_its_moments() {
        let delay = Term::new(effect("transport_delay").unwrap(), vec![0.3e-3]);
        let model = Model::nominal([1.0, 1.0, 1.0], Hold::ZeroOrder).with(delay);
        let [m0, m1, m2] = along_a_jump(&model)[2];
        assert!((m0 - 0.7).abs() < 1e-12);
        assert!((m1 - 0.5 * (1.0 - 0.09)).abs() < 1e-12);
        assert!((m2 - (1.0 - 0.027) / 3.0).abs() < 1e-12);
    }

    /// A lag shorter than a sample, whose transient is no parabola, keeps its moments beside a hysteresis of no strength.
    #[test]
    fn a_hysteresis_of_no_strength_changes_nothing_behind_a_lag() {
        let term = |id: &str, value: f64| Term::new(effect(id).unwrap(), vec![value]);
        let lagging = Model::nominal([1.0, 1.0, 1.0], Hold::ZeroOrder).with(term("drive_lag", 1e-4));
        let without = along_a_jump(&lagging);
        let with = along_a_jump(&lagging.with(term("rayleigh_hysteresis", 0.0)));
        assert!((without[2][0] - (1.0 - 0.1)).abs() < 1e-4, "{without:?}");
        for (a, b) in without.iter().flatten().zip(with.iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "{without:?} {with:?}");
        }
    }
}
