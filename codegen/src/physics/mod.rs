//! Further physics in the routine: the terms that a diagnosis found and firmware can correct at run time.
//!
//! The function of the reading stays as it is designed ([`crate::fused`], [`crate::piecewise`]); between its last
//! sum and the output's format the terms are subtracted, from further inputs and from a state that is kept from
//! call to call. Every word of that is bounded as it is written (`builder`), over all words of all inputs and
//! all states that can be reached; what it is off adds to the bound of the function.

mod builder;
mod further;
mod hinge;
mod lag;
mod periodic;
mod play;
mod product;
mod rate;
mod shape;

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Hinge, Operator, Rate, Scope, Term};

use crate::bound::{self, Overflows};
use crate::design::{Design, DesignError};
use crate::exact::{Interval, arcsec_per_rad};
use crate::format::Format;
use crate::input::InputPlan;
use crate::options::Options;
use crate::output::Output;
use crate::program::{Op, Operand, Program, Stage, Type};
use crate::reference::TooSteep;

use builder::{Builder, Tracked};
use further::Given;
use shape::Variable;

pub use further::{Further, FurtherEncoding};

/// The terms of a coefficients file as a routine has them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Physics {
    /// Those that are generated.
    pub terms: Vec<Term>,
    /// The further inputs.
    pub further: Vec<Further>,
    /// Seconds between two calls, where a term needs it.
    pub period_s: f64,
    /// Effects that are left out, and why.
    pub left_out: Vec<(String, String)>,
}

/// Why the terms cannot be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PhysicsError {
    /// A further input that is not understood.
    #[error(
        "--further {0}: give the column, its valid range and how it arrives, for example temperature_c=15..35 \
         (a Q31 word) or temperature_c=15..35:counts:12:0.05:-400 (bits, gain, the count that stands for zero)"
    )]
    Further(String),
    /// A box that the words do not reach.
    #[error("`{observable}` as described reaches {}…{} only, its box is {from}…{to}", reaches.0, reaches.1)]
    Box {
        /// The further input.
        observable: String,
        /// Its box.
        from: f64,
        /// Its box.
        to: f64,
        /// What its words can express.
        reaches: (f64, f64),
    },
    /// A further input that is not described.
    #[error(
        "the term `{kind}` of {effect} needs `{observable}` at run time: describe that input, for example \
         --further {observable}=FROM..TO, or leave the effect out with --without {effect}"
    )]
    Needs {
        /// The effect.
        effect: String,
        /// Its operator.
        kind: &'static str,
        /// What it reads.
        observable: String,
    },
    /// A further input that no term reads.
    #[error("--further {0}: no term of the coefficients reads `{0}`")]
    Unread(String),
    /// An effect that is not there.
    #[error("--without {0}: the coefficients have no term of that effect")]
    NoSuchEffect(String),
    /// A term that is not generated.
    #[error(
        "the term `{kind}` of {effect} cannot be generated yet{why}: leave it out with --without {effect}, and the \
         heads of the files will say so"
    )]
    NotGenerated {
        /// The effect.
        effect: String,
        /// Its operator.
        kind: &'static str,
        /// What about it.
        why: &'static str,
    },
    /// A format without long products.
    #[error("terms of further physics need the format q31 or q31-split, not {0}: add --format q31")]
    Format(&'static str),
    /// A play too narrow for a word.
    #[error("a play of half-width {0} is too narrow for words of 32 bits")]
    NarrowPlay(f64),
    /// A coefficient too large.
    #[error("a coefficient of a term is too large for words of 32 bits")]
    TooLarge,
    /// A period that is none.
    #[error("--period-s {0}: give the time between two calls of the routine in seconds, above zero")]
    Period(f64),
    /// A term that needs the period.
    #[error(
        "the term `{kind}` of {effect} needs the time between two calls of the routine: give --period-s, or leave the \
         effect out with --without {effect}"
    )]
    NeedsPeriod {
        /// The effect.
        effect: String,
        /// Its operator.
        kind: &'static str,
    },
    /// The range is too wide.
    #[error(transparent)]
    TooSteep(#[from] TooSteep),
    /// Some word could overflow.
    #[error(transparent)]
    Overflows(Overflows),
}

/// The last sum of the routine, from which the terms are subtracted: a word of 2^−bits of the result's unit.
struct Sum {
    word: Tracked,
    bits: i64,
    /// What an approximation may be off, in words.
    tolerance: Interval,
    /// A part this small need not be evaluated.
    negligible: Interval,
    /// How much of an error before the terms is left after them, 1 where they only add.
    gain: Interval,
}

impl Sum {
    /// Adds a·factor·2⁻³².
    fn add_scaled(
        &mut self,
        b: &mut Builder,
        factor: &Interval,
        a: &Tracked,
        note: &str,
    ) -> Result<(), PhysicsError> {
        let largest = Interval::from_int(i32::MAX.into());
        let fits = |shift: &i64| factor.mul_pow2(-shift).magnitude().certainly_le(&largest);
        let shift = (0..30).find(fits).ok_or(PhysicsError::TooLarge)?;
        let factor = Tracked::constant(&factor.mul_pow2(-shift));
        self.word = b.mul_add("y", (&factor, a), shift as u32, &self.word, note)?;
        Ok(())
    }

    /// Adds a constant of the sum's words.
    fn add_constant(&mut self, b: &mut Builder, constant: &Interval) -> Result<(), PhysicsError> {
        if constant.magnitude().certainly_le(&self.negligible) {
            self.word.error = (&self.word.error + &constant.magnitude()).upper();
        } else {
            self.word = b.add("y", &self.word, &Tracked::constant(constant), "")?;
        }
        Ok(())
    }
}

impl Physics {
    /// The terms of the file: those of the device are generated, but for the effects in `without`; those of
    /// the one recording are left out, and `beyond` what was recorded those that do not extrapolate.
    ///
    /// # Errors
    /// [`PhysicsError`] where a term needs an input that is not described, or cannot be generated.
    pub fn of(coefficients: &Coefficients, options: &Options, beyond: bool) -> Result<Physics, PhysicsError> {
        let (further, without) = (&options.further, &options.without);
        if let Some(period) = options.period_s.filter(|p| !(p.is_finite() && *p > 0.0)) {
            return Err(PhysicsError::Period(period));
        }
        if let Some(effect) = without.iter().find(|e| !coefficients.terms.iter().any(|t| t.effect == **e)) {
            return Err(PhysicsError::NoSuchEffect(effect.clone()));
        }
        let mut physics = Physics::default();
        for term in &coefficients.terms {
            if without.contains(&term.effect) {
                physics.left_out.push((term.effect.clone(), "as asked for".into()));
            } else if term.scope == Scope::Recording {
                let why = "it holds on the recording that it was found in only";
                physics.left_out.push((term.effect.clone(), why.into()));
            } else if beyond && !term.operator.extrapolates() {
                let why = "it is not known beyond the recording";
                physics.left_out.push((term.effect.clone(), why.into()));
            } else {
                can_be_generated(term, &coefficients.sensor, options)?;
                physics.terms.push(term.clone());
            }
        }
        let mut periods = physics.terms.iter().filter_map(|t| match &t.operator {
            Operator::Periodic(p) => Some((t, p.period)),
            _ => None,
        });
        if let Some((_, first)) = periods.next()
            && let Some((other, _)) = periods.find(|(_, period)| *period != first)
        {
            let why = " beside one of another period: together they do not repeat";
            return Err(PhysicsError::NotGenerated { effect: other.effect.clone(), kind: "periodic", why });
        }
        let read = |input: &Further| {
            physics.terms.iter().any(|t| t.operator.observables().contains(&input.observable.as_str()))
        };
        if let Some(input) = further.iter().find(|input| !read(input)) {
            return Err(PhysicsError::Unread(input.observable.clone()));
        }
        physics.further.clone_from(further);
        physics.period_s = options.period_s.unwrap_or(0.0);
        Ok(physics)
    }

    /// Whether nothing is added to the function of the reading.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// `design` with the terms; `target` is the bound that is wanted, in the result's unit.
    ///
    /// # Errors
    /// [`DesignError`] where a word could overflow, or the format has no long products.
    pub fn extend(
        &self,
        design: Design,
        model: &ErrorModel,
        plan: &InputPlan,
        (format, output): (Format, Output),
        target: f64,
    ) -> Result<Design, DesignError> {
        if self.is_empty() {
            return Ok(design);
        }
        if !matches!(format, Format::Q31 | Format::Q31Split) {
            return Err(PhysicsError::Format(format.name()).into());
        }
        let at = design.program.steps.iter().position(|s| s.stage == Stage::Output);
        let at = at.unwrap_or(design.program.steps.len());
        let unit = Interval::from_int(1).mul_pow2(-design.sum_bits);
        let range = Interval::from_f64(design.bound.output_range.0)
            .hull(&Interval::from_f64(design.bound.output_range.1));
        // The result's words as words of the sum, wider for the roundings in between.
        let one = if output == Output::F32 { Interval::zero() } else { design.unit.mul_pow2(1).div(&unit) };
        let range = (&range * &design.unit).div(&unit);
        let wider = &(&range.magnitude().mul_pow2(-20) + &one) + &Interval::from_int(8);
        let range = &range + &wider.symmetric();
        let word = Tracked { operand: Operand::Step(at - 1), range, error: Interval::zero() };
        let quarter = Interval::from_int(1).mul_pow2(-2);
        let wanted = Interval::from_f64(target).mul_pow2(design.sum_bits - 5);
        let mut sum = Sum {
            word,
            bits: design.sum_bits,
            tolerance: quarter.hull(&wanted).upper(),
            negligible: quarter,
            gain: Interval::from_int(1),
        };
        let mut b = Builder { program: design.program.clone(), format };
        b.program.steps.truncate(at);
        self.subtract(&mut b, &mut sum, model, plan)?;
        let gain = sum.gain.to_f64_up();

        let mut program = b.program;
        let rest = finish(&mut program, &design.program, at, &sum.word)?;
        let mut bound = design.bound.clone();
        // Where the terms enlarge what the function is off, that is listed with them.
        let before = bound.approximation + bound.input + bound.evaluation;
        bound.terms = ((&sum.word.error * &unit).to_f64_up() + (gain - 1.0).next_up() * before).next_up();
        if output == Output::F32 {
            // A larger result has larger roundings.
            let largest = (&sum.word.range.magnitude() * &unit).log2_floor().unwrap_or(-100);
            bound.output = bound.output.max(Interval::from_int(1).mul_pow2(largest - 24).to_f64_up());
        }
        let sum_of = [bound.approximation, bound.input, bound.evaluation, bound.output, bound.terms];
        bound.total = sum_of.iter().fold(0.0, |sum: f64, part| (sum + part).next_up());
        let words = (&sum.word.range * &unit).div(&design.unit);
        bound.output_range = (words.to_f64_down(), words.to_f64_up());
        debug_assert!(rest <= program.steps.len());
        Ok(Design { program, bound, ..design })
    }

    /// Appends the steps of all terms.
    fn subtract(
        &self,
        b: &mut Builder,
        sum: &mut Sum,
        model: &ErrorModel,
        plan: &InputPlan,
    ) -> Result<(), PhysicsError> {
        // What one unit of the file's statistics is in the result's unit.
        let statistic = match model.sensor {
            Sensor::EddyCurrentPair { .. } => Interval::from_int(1).div(&arcsec_per_rad()),
            Sensor::Direct { .. } => Interval::from_int(1),
        };
        let (from, to) = bound::reach(&b.program, plan);
        let exponent = b.program.variable_exponent;
        let error = bound::variable_error(&b.program, plan).mul_pow2(exponent).upper();
        let word = Tracked { operand: Operand::Step(b.program.variable), range: from.hull(&to), error };
        let variable = Variable { model, plan, word, exponent };
        let mut given: Vec<(String, Given)> = Vec::new();
        for input in &self.further {
            let centre = self.mean(&input.observable).unwrap_or(0.5 * (input.from + input.to));
            given.push((input.observable.clone(), input.push(b, centre)?));
        }
        let mut expanded = product::Expanded::new();
        for term in &self.terms {
            let weights: Vec<Interval> =
                term.coefficients.iter().map(|c| &Interval::from_f64(*c) * &statistic).collect();
            match &term.operator {
                Operator::Product(product) => {
                    product::expand(&mut expanded, product, &weights[0], &variable, &given)?;
                }
                Operator::Play(play) => {
                    let Some(observable) = variable.observable(&play.observable)? else { continue };
                    // Coefficients are in the statistics' unit per unit of the observable.
                    play::subtract(b, sum, play, &weights, &variable, &observable)?;
                }
                Operator::Lag(lag) => {
                    let Some((_, input)) = given.iter().find(|(name, _)| *name == lag.observable) else {
                        continue;
                    };
                    lag::subtract(b, sum, lag, &weights[0], input, self.period_s)?;
                }
                Operator::Rate(rate) => {
                    let Some(observable) = variable.observable(&rate.observable)? else { continue };
                    rate::subtract(b, sum, &weights[0], &variable, &observable, self.period_s)?;
                }
                Operator::Hinge(hinge) => {
                    let Some(observable) = variable.observable(&hinge.observable)? else { continue };
                    hinge::subtract(b, sum, hinge, &weights[0], &variable, &observable)?;
                }
                _ => {}
            }
        }
        product::subtract(b, sum, &expanded, &variable, &given)?;
        periodic::solve(b, sum, &self.terms, &statistic)
    }

    /// What is subtracted, term by term, for the head of a file.
    pub fn terms_in_words(&self) -> Vec<String> {
        let factor = |f: &fitter::terms::Factor| {
            let power = if f.power > 1 { format!("^{}", f.power) } else { String::new() };
            if f.mean == 0.0 {
                format!("{}{power}", f.observable)
            } else {
                format!("({} − {:?}){power}", f.observable, f.mean)
            }
        };
        let in_words = |term: &Term| match &term.operator {
            Operator::Product(p) => {
                let factors: Vec<String> = p.factors.iter().map(factor).collect();
                format!("{}: {:?}·{}", term.effect, term.coefficients[0], factors.join("·"))
            }
            Operator::Play(p) => {
                let elements: Vec<String> = (p.elements.iter().zip(&term.coefficients))
                    .map(|(e, w)| format!("{w:?}·(v − play of half-width {:?})", e.half_width))
                    .collect();
                format!("{}: v = {}; {}", term.effect, p.observable, elements.join(" + "))
            }
            Operator::Periodic(p) => format!(
                "{}: {} harmonics of period {:?} of the corrected result itself",
                term.effect,
                p.harmonics.len(),
                p.period
            ),
            Operator::Lag(l) => format!(
                "{}: {:?}·({} lagged by {:?} s − {:?}), a call every {:?} s",
                term.effect, term.coefficients[0], l.observable, l.time_constant_s, l.mean, self.period_s
            ),
            Operator::Rate(r) => format!(
                "{}: {:?}·d({})/dt by the difference to the call before, {:?} s ago; 0 at the first call",
                term.effect, term.coefficients[0], r.observable, self.period_s
            ),
            Operator::Hinge(h) => format!(
                "{}: {:?}·how far {} is {} {:?}",
                term.effect,
                term.coefficients[0],
                h.observable,
                if h.side == fitter::terms::Side::Above { "above" } else { "below" },
                h.threshold
            ),
            other => format!("{}: {}", term.effect, other.kind()),
        };
        self.terms.iter().map(in_words).collect()
    }

    /// The reference mean of an observable, where a product has one.
    fn mean(&self, observable: &str) -> Option<f64> {
        let factors = self.terms.iter().filter_map(|t| match &t.operator {
            Operator::Product(product) => Some(&product.factors),
            _ => None,
        });
        let lags = self.terms.iter().filter_map(|t| match &t.operator {
            Operator::Lag(lag) if lag.observable == observable => Some(lag.mean),
            _ => None,
        });
        factors
            .flatten()
            .find(|f| f.observable == observable)
            .map(|f| f.mean)
            .or_else(|| lags.into_iter().next())
    }
}

/// Whether a term is one of those that are generated, and its inputs are there.
fn can_be_generated(term: &Term, sensor: &Sensor, options: &Options) -> Result<(), PhysicsError> {
    let kind = term.operator.kind();
    let effect = term.effect.clone();
    let of_reading = |name: &str| match sensor {
        Sensor::EddyCurrentPair { .. } => matches!(name, "s_mm" | "angle_deg" | "angle_arcsec"),
        Sensor::Direct { .. } => name == "measured",
    };
    let given = |name: &str| options.further.iter().any(|f| f.observable == name);
    let refuse = |why: &'static str| Err(PhysicsError::NotGenerated { effect: effect.clone(), kind, why });
    match &term.operator {
        Operator::Product(product) => {
            for factor in &product.factors {
                let name = &factor.observable;
                if !of_reading(name) && !given(name) {
                    return Err(PhysicsError::Needs { effect, kind, observable: name.clone() });
                }
            }
            Ok(())
        }
        Operator::Play(play) if !of_reading(&play.observable) => {
            refuse(" of another observable than the reading")
        }
        Operator::Rate(Rate { observable }) | Operator::Hinge(Hinge { observable, .. })
            if !of_reading(observable) =>
        {
            refuse(" of another observable than the reading")
        }
        Operator::Lag(lag) if !given(&lag.observable) => {
            Err(PhysicsError::Needs { effect, kind, observable: lag.observable.clone() })
        }
        Operator::Lag(_) | Operator::Rate(_) if options.period_s.is_none() => {
            Err(PhysicsError::NeedsPeriod { effect, kind })
        }
        Operator::Play(_)
        | Operator::Periodic(_)
        | Operator::Hinge(_)
        | Operator::Lag(_)
        | Operator::Rate(_) => Ok(()),
        _ => refuse(""),
    }
}

/// Appends the steps of `before` from `at` on, which make the output of the sum, so that they read `sum` instead;
/// gives where they begin.
fn finish(program: &mut Program, before: &Program, at: usize, sum: &Tracked) -> Result<usize, DesignError> {
    let begin = program.steps.len();
    let moved = |operand: Operand| match operand {
        Operand::Step(i) if i + 1 == at => sum.operand,
        Operand::Step(i) if i >= at => Operand::Step(i - at + begin),
        other => other,
    };
    let word = Interval::from_int(i32::MIN.into()).hull(&Interval::from_int(i32::MAX.into()));
    for step in &before.steps[at..] {
        let mut step = step.clone();
        // An integer output is the sum times a constant.
        if let Op::MulAddHigh { b: Operand::Int(m), shift, .. }
        | Op::MulAddSplit { b: Operand::Int(m), shift, .. } = &step.op
        {
            let scaled = (&sum.range * &Interval::from_int(*m)).mul_pow2(i64::from(*shift) - 32);
            let range = &scaled + &Interval::from_int(4).mul_pow2((*shift).into()).symmetric();
            if !range.inside(&word) {
                return Err(DesignError::Overflows(Overflows {
                    step: program.steps.len(),
                    name: step.name.clone(),
                    stage: Stage::Output,
                    from: range.to_f64_down(),
                    to: range.to_f64_up(),
                    ty: Type::I32,
                }));
            }
        }
        step.op = step.op.on(moved);
        program.steps.push(step);
    }
    Ok(begin)
}

impl From<PhysicsError> for DesignError {
    fn from(cause: PhysicsError) -> Self {
        match cause {
            PhysicsError::Overflows(cause) => DesignError::Overflows(cause),
            cause => DesignError::Physics(cause),
        }
    }
}
