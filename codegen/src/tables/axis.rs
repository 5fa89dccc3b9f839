//! An axis between two ends: what it has to be commanded to so that it goes to a position, and how far a table of straight
//! lines is from that at most.

use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;
use fitter::terms::{Operator, Periodic, Product, Scope, Term};
use rayon::prelude::*;

use super::linuxcnc::{Entry, MOST_ENTRIES};
use super::{Asked, TableError};
use crate::approximate::to_chebyshev;
use crate::exact::{Interval, cos_sin, pi};
use crate::extent::LeftOut;

/// Periods in the range for which there are four entries each.
const MOST_PERIODS: f64 = (MOST_ENTRIES / 4 - 1) as f64;
/// Places in a stretch at which the bound is computed.
const PLACES: u32 = 64;
/// Steps of Newton's method.
const STEPS: usize = 30;
/// The slope from which on no inverse is claimed.
const STEEPEST: f64 = 0.5;

/// What a position has to be commanded to.
pub struct Axis {
    /// Coefficients of the polynomial of the reading, about its centre.
    polynomial: Vec<Interval>,
    centre: f64,
    /// Periodic errors of the true position.
    waves: Vec<Wave>,
    /// Half of the lost motion: what a move up adds to the error, and a move down takes off.
    half: Interval,
    /// By how much the machine's positions are above the reference's: at position 0, or at the end nearest to it, the
    /// command is left as it is on average of both directions.
    pub zero: f64,
    /// How far a command may be from the centre.
    reach: f64,
    /// Upper bound of the polynomial's slope there.
    steepest: f64,
    /// First and last position.
    pub range: (f64, f64),
    /// Periods of the shortest wave in the range.
    pub periods: f64,
    /// The terms that are in the table.
    pub taken: Vec<Term>,
    /// Those that are not, with their sizes.
    pub left_out: Vec<LeftOut>,
}

/// A periodic error of the true position.
struct Wave {
    harmonic: u32,
    period: f64,
    /// The coefficients of cosine and sine.
    cosine: f64,
    sine: f64,
}

impl Wave {
    /// Radians for each unit of the position.
    fn rate(&self) -> f64 {
        std::f64::consts::TAU * f64::from(self.harmonic) / self.period
    }

    fn amplitude(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    fn at(&self, position: f64) -> f64 {
        let (sine, cosine) = (self.rate() * position).sin_cos();
        self.cosine * cosine + self.sine * sine
    }

    /// Cosine and sine, enclosed.
    fn phase(&self, position: &Interval) -> (Interval, Interval) {
        let turn = pi().mul_pow2(1);
        let turns =
            (&Interval::from_int(i64::from(self.harmonic)) * position).div(&Interval::from_f64(self.period));
        let whole = Interval::from_int(turns.midpoint().floor_to_i64().unwrap_or(0));
        cos_sin(&(&(&turns - &whole) * &turn))
    }
}

impl Axis {
    /// Of the coefficients of a sensor that reports its position.
    ///
    /// # Errors
    /// [`TableError`] where they are of something else, or the error is too steep.
    pub fn of(coefficients: &Coefficients, asked: &Asked<'_>) -> Result<Axis, TableError> {
        match &coefficients.sensor {
            Sensor::Direct { revolution: None, .. } => {}
            Sensor::Direct { .. } => return Err(TableError::Wraps),
            Sensor::EddyCurrentPair { .. } => return Err(TableError::NotDirect),
        }
        let covered = &coefficients.valid_range;
        let range = asked.options.range.unwrap_or((covered.from, covered.to));
        let beyond = range.0 < covered.from || range.1 > covered.to;
        if range.0 >= range.1 || (beyond && !asked.options.extrapolate) {
            return Err(TableError::Range { range, covered: (covered.from, covered.to) });
        }
        let mut axis = Axis {
            polynomial: [&coefficients.base.coefficients[..], &[0.0; 2]]
                .concat()
                .into_iter()
                .map(Interval::from_f64)
                .collect(),
            centre: coefficients.base.centre,
            waves: Vec::new(),
            half: Interval::zero(),
            zero: 0.0,
            reach: 0.0,
            steepest: 0.0,
            range,
            periods: 0.0,
            taken: Vec::new(),
            left_out: Vec::new(),
        };
        for term in &coefficients.terms {
            match axis.take(term) {
                Ok(()) => axis.taken.push(term.clone()),
                Err(why) => {
                    let device = term.scope == Scope::Device;
                    axis.left_out.push(LeftOut::of(term, coefficients, axis.range, why, device));
                }
            }
        }
        axis.set_zero();
        axis.set_reach()?;
        Ok(axis)
    }

    /// Takes a term into the table, or says why it is left out.
    fn take(&mut self, term: &Term) -> Result<(), &'static str> {
        let weight = Interval::from_f64(term.coefficients.first().copied().unwrap_or(0.0));
        let add = |to: &mut Interval, more: &Interval| *to = &*to + more;
        Err(match &term.operator {
            _ if term.scope == Scope::Recording => "it belongs to the recording, not to the device",
            Operator::Play(play) if play.observable == "measured" => {
                for (element, c) in play.elements.iter().zip(&term.coefficients) {
                    let half = &Interval::from_f64(element.half_width) * &Interval::from_f64(*c);
                    add(&mut self.half, &half);
                }
                return Ok(());
            }
            Operator::Product(product) if factor(product, "direction").is_some() => {
                let mean = Interval::from_f64(factor(product, "direction").unwrap_or_default());
                add(&mut self.half, &weight);
                add(&mut self.polynomial[0], &-(&weight * &mean));
                return Ok(());
            }
            // A slope, and a constant.
            Operator::Product(product) if factor(product, "measured").is_some() => {
                let mean = Interval::from_f64(factor(product, "measured").unwrap_or_default());
                let from_mean = &Interval::from_f64(self.centre) - &mean;
                add(&mut self.polynomial[0], &(&weight * &from_mean));
                add(&mut self.polynomial[1], &weight);
                return Ok(());
            }
            Operator::Periodic(periodic) if self.periods_of(periodic) > MOST_PERIODS => {
                "it has more periods than the file has entries for"
            }
            Operator::Periodic(periodic) => {
                self.periods = self.periods.max(self.periods_of(periodic));
                for (k, pair) in periodic.harmonics.iter().zip(term.coefficients.chunks_exact(2)) {
                    let (harmonic, period) = (u32::from(*k), periodic.period);
                    self.waves.push(Wave { harmonic, period, cosine: pair[0], sine: pair[1] });
                }
                return Ok(());
            }
            Operator::Rate(_) => "a position alone does not tell the speed",
            _ => "it is no function of position and direction that the table is made of",
        })
    }

    /// Periods of the shortest wave in the range.
    fn periods_of(&self, periodic: &Periodic) -> f64 {
        let highest = periodic.harmonics.iter().copied().max().unwrap_or(0);
        (self.range.1 - self.range.0) * f64::from(highest) / periodic.period
    }

    /// Takes the zero off the polynomial.
    fn set_zero(&mut self) {
        let home = 0.0f64.clamp(self.range.0, self.range.1);
        let straight = home - self.polynomial_at(home).0;
        // r + P(r) = straight: the steps fall with P's slope, which the file's reader limits.
        let reference = (0..200).fold(straight, |reference, _| straight - self.waves_at(reference));
        self.zero = home - reference;
        self.polynomial[0] = &self.polynomial[0] - &Interval::from_f64(self.zero);
    }

    /// The largest distance of a command from the centre: R = r + the largest trim within R, so that all commands lie within.
    fn set_reach(&mut self) -> Result<(), TableError> {
        let positions = (self.range.0 - self.centre).abs().max((self.range.1 - self.centre).abs());
        let waves: f64 = self.waves.iter().map(Wave::amplitude).sum();
        self.reach = positions;
        for _ in 0..STEPS {
            if self.slopes(1) >= STEEPEST {
                return Err(TableError::Steep { steepest: self.slopes(1) });
            }
            let fixed = waves + self.half.magnitude().to_f64_up();
            self.reach = (positions + self.slopes(0) + fixed) * (1.0 + 1e-9);
        }
        self.steepest = self.slopes(1);
        Ok(())
    }

    /// The polynomial and its derivative at a command.
    fn polynomial_at(&self, command: f64) -> (f64, f64) {
        let x = command - self.centre;
        let step = |(value, slope): (f64, f64), c: &Interval| (value * x + c.to_f64(), slope * x + value);
        self.polynomial.iter().rev().fold((0.0, 0.0), step)
    }

    /// The waves at a position on the reference's scale.
    fn waves_at(&self, reference: f64) -> f64 {
        self.waves.iter().map(|wave| wave.at(reference)).sum()
    }

    /// The trim at a position: `direction` is 1 while the joint moves up, −1 while it moves down, 0 between both.
    pub fn trim(&self, position: f64, direction: f64) -> f64 {
        let fixed = direction * self.half.to_f64() + self.waves_at(position - self.zero);
        // m − q(m) = p + fixed, for the difference of m and p.
        let mut trim = fixed;
        for _ in 0..STEPS {
            let (value, slope) = self.polynomial_at(position + trim);
            let step = (trim - value - fixed) / (1.0 - slope);
            trim -= step;
            if step.abs() <= 2.0 * f64::EPSILON * trim.abs() {
                break;
            }
        }
        trim
    }

    /// Upper bound of the polynomial's derivative of this order at all commands: the sum of the magnitudes of its Chebyshev
    /// coefficients there.
    fn slopes(&self, order: usize) -> f64 {
        let reach = Interval::from_f64(self.reach);
        let mut power = Interval::from_int(1);
        let scaled = self.polynomial.iter().map(|c| {
            let scaled = c * &power;
            power = &power * &reach;
            scaled
        });
        let scaled: Vec<Interval> = scaled.collect();
        let mut series: Vec<f64> = to_chebyshev(&scaled).iter().map(Interval::to_f64).collect();
        for _ in 0..order {
            // c′ₖ₋₁ = c′ₖ₊₁ + 2k cₖ, and half of the first.
            let mut derivative = vec![0.0; series.len() + 1];
            for k in (1..series.len()).rev() {
                derivative[k - 1] = derivative[k + 1] + 2.0 * k as f64 * series[k];
            }
            derivative[0] *= 0.5;
            derivative.truncate(series.len() - 1);
            series = derivative;
        }
        let sum: f64 = series.iter().map(|c| c.abs()).sum();
        sum / self.reach.powi(order as i32) * (1.0 + 1e-9)
    }

    /// Upper bound of the distance of what LinuxCNC adds from the trims, over all positions of the range and both directions:
    /// the largest at many places, what a curve can do between two of them, and what LinuxCNC rounds.
    pub fn bound(&self, kept: &[Entry]) -> f64 {
        let curvature = self.curvature();
        let stretch = |pair: &[Entry]| {
            let width = (pair[1].nominal - pair[0].nominal) * (1.0 + f64::EPSILON);
            let between = 0.125 * curvature * (width / f64::from(PLACES)).powi(2);
            let rounded =
                pair[0].trims.map(|(trim, slope)| f64::from(trim.abs()) + f64::from(slope.abs()) * width);
            // Three operations, each off by half a unit in the last place of no more than this.
            let rounded = 2.0 * f64::EPSILON * rounded[0].max(rounded[1]);
            (self.farthest(&pair[0], pair[1].nominal) + between + rounded) * (1.0 + 1e-9)
        };
        kept.par_windows(2).map(stretch).reduce(|| 0.0, f64::max)
    }

    /// Upper bound of that distance at the places of one stretch, in exact arithmetic.
    fn farthest(&self, entry: &Entry, to: f64) -> f64 {
        let from = Interval::from_f64(entry.nominal);
        let step = (&Interval::from_f64(to) - &from).div(&Interval::from_int(PLACES.into()));
        let zero = Interval::from_f64(self.zero);
        let reference = &from - &zero;
        let mut phases: Vec<(Interval, Interval)> =
            self.waves.iter().map(|wave| wave.phase(&reference)).collect();
        let turns: Vec<(Interval, Interval)> = self.waves.iter().map(|wave| wave.phase(&step)).collect();
        let mut along = Interval::zero();
        let mut largest = 0.0f64;
        for _ in 0..=PLACES {
            let waves =
                self.waves.iter().zip(&phases).fold(Interval::zero(), |sum, (wave, (cosine, sine))| {
                    &sum + &(&(&Interval::from_f64(wave.cosine) * cosine)
                        + &(&Interval::from_f64(wave.sine) * sine))
                });
            let directions = [(1.0, &waves + &self.half), (-1.0, &waves - &self.half)];
            for ((trim, slope), (direction, fixed)) in entry.trims.into_iter().zip(directions) {
                let line = &Interval::from_f64(trim.into()) + &(&Interval::from_f64(slope.into()) * &along);
                let off = &line - &self.enclosed_trim(&(&from + &along), direction, &fixed);
                largest = largest.max(off.magnitude().to_f64_up());
            }
            along = &along + &step;
            for ((cosine, sine), (c, s)) in phases.iter_mut().zip(&turns) {
                (*cosine, *sine) = (&(&*cosine * c) - &(&*sine * s), &(&*sine * c) + &(&*cosine * s));
            }
        }
        largest
    }

    /// The trim at a position, enclosed: Newton's result, and the residual there over the least slope. `fixed` is what of the error
    /// does not depend on the command.
    fn enclosed_trim(&self, position: &Interval, direction: f64, fixed: &Interval) -> Interval {
        let trim = Interval::from_f64(self.trim(position.to_f64(), direction));
        let x = &(position + &trim) - &Interval::from_f64(self.centre);
        let polynomial = self.polynomial.iter().rev().fold(Interval::zero(), |value, c| &(&value * &x) + c);
        let residual = &(&trim - &polynomial) - fixed;
        // The slope of m − q(m) is at least 1 − steepest wherever a command can be.
        let least = &Interval::from_int(1) - &Interval::from_f64(self.steepest);
        &trim + &residual.div(&least).symmetric()
    }

    /// Upper bound of the trim's second derivative: of m(p) with (1 − q′) m′ = 1 + P′.
    fn curvature(&self) -> f64 {
        let waves = |order: i32| {
            self.waves.iter().map(|wave| wave.amplitude() * wave.rate().powi(order)).sum::<f64>()
        };
        let straight = 1.0 - self.steepest;
        let slope = (1.0 + waves(1)) / straight;
        (waves(2) + self.slopes(2) * slope * slope) / straight
    }
}

/// The mean from which a product counts the observable, where it is that alone.
fn factor(product: &Product, observable: &str) -> Option<f64> {
    match &product.factors[..] {
        [only] if only.observable == observable && only.power == 1 => Some(only.mean),
        _ => None,
    }
}
