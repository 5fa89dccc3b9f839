//! Which terms are generated, which are left out by name, and which are refused.

use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;
use fitter::terms::{Exponential, Operator, Scope, Term};

use super::expression::Tree;
use super::{Further, Physics, PhysicsError};
use crate::extent::LeftOut;
use crate::options::Options;

/// The observable that is the time.
const TIME: &str = "t_s";
/// Columns of a recording that only the reference instrument of a calibration has.
const REFERENCE: [&str; 3] = ["reference_arcsec", "reference", "cross_arcsec"];

impl Physics {
    /// The terms of the file: those of the device are generated, but for the effects in `without`; those of
    /// the one recording are left out unless they are kept, and `beyond` what was recorded those that do not
    /// extrapolate.
    ///
    /// # Errors
    /// [`PhysicsError`] where a term needs an input that is not described, or cannot be generated; where terms or
    /// options contradict each other; where an input's box is wider than what was recorded.
    pub fn of(coefficients: &Coefficients, options: &Options, beyond: bool) -> Result<Physics, PhysicsError> {
        consistent(coefficients, options)?;
        let mut physics = Physics { sensor: Some(coefficients.sensor.clone()), ..Physics::default() };
        let covered = &coefficients.valid_range;
        let range = options.range.unwrap_or((covered.from, covered.to));
        for term in &coefficients.terms {
            match left_out(term, options, beyond) {
                Some(why) => {
                    let counts = term.scope == Scope::Device && never(term).is_none();
                    physics.left_out.push(LeftOut::of(term, coefficients, range, &why, counts));
                }
                None => {
                    can_be_generated(term, &coefficients.sensor, options)?;
                    physics.terms.push(term.clone());
                }
            }
        }
        contradiction(&physics.terms)?;
        let read = |input: &Further| {
            physics.terms.iter().any(|t| t.operator.observables().contains(&input.observable.as_str()))
        };
        if let Some(input) = options.further.iter().find(|input| !read(input)) {
            return Err(PhysicsError::Unread(input.observable.clone()));
        }
        physics.further.clone_from(&options.further);
        physics.period_s = options.period_s.unwrap_or(0.0);
        Ok(physics)
    }
}

/// Holds the options against each other and against the file.
fn consistent(coefficients: &Coefficients, options: &Options) -> Result<(), PhysicsError> {
    if let Some(period) = options.period_s.filter(|p| !(p.is_finite() && *p > 0.0)) {
        return Err(PhysicsError::Period(period));
    }
    for (option, named) in [("without", &options.without), ("keep", &options.keep)] {
        if let Some(effect) = named.iter().find(|e| !coefficients.terms.iter().any(|t| t.effect == **e)) {
            let mut known: Vec<&str> = coefficients.terms.iter().map(|t| t.effect.as_str()).collect();
            known.dedup();
            let there =
                if known.is_empty() { String::new() } else { format!(", only of {}", known.join(", ")) };
            return Err(PhysicsError::NoSuchEffect { option, effect: effect.clone(), there });
        }
    }
    if let Some(effect) = options.keep.iter().find(|e| options.without.contains(e)) {
        return Err(PhysicsError::KeptAndLeftOut(effect.clone()));
    }
    let kept = coefficients.terms.iter().filter(|t| options.keep.contains(&t.effect));
    for term in kept {
        let not = |why| Err(PhysicsError::NotKept { effect: term.effect.clone(), why });
        if term.scope == Scope::Device {
            return not("it holds for the device and is generated in any case");
        }
        if let Some(why) = never(term) {
            return not(why);
        }
    }
    for (i, input) in options.further.iter().enumerate() {
        if options.further[..i].iter().any(|other| other.observable == input.observable) {
            return Err(PhysicsError::GivenTwice(input.observable.clone()));
        }
        let recorded = coefficients.observed.get(&input.observable);
        if let Some([from, to]) = recorded.filter(|_| !options.extrapolate)
            && (input.from < *from || input.to > *to)
        {
            return Err(PhysicsError::BeyondRecorded {
                observable: input.observable.clone(),
                from: input.from,
                to: input.to,
                recorded: (*from, *to),
            });
        }
    }
    Ok(())
}

/// Why no routine can ever correct a term; none where it can.
fn never(term: &Term) -> Option<&'static str> {
    match &term.operator {
        Operator::Step(step) if step.observable == TIME => {
            Some("a step at a past date is over by the time the routine runs; calibrate again to correct it")
        }
        other if other.observables().iter().any(|name| REFERENCE.contains(name)) => {
            Some("it is the reference instrument's own error, which is not in what the routine reads")
        }
        _ => None,
    }
}

/// Why a term is left out; none where it is generated.
fn left_out(term: &Term, options: &Options, beyond: bool) -> Option<String> {
    let since_start = term.operator.observables().first() == Some(&TIME);
    if options.without.contains(&term.effect) {
        return Some("as asked for".into());
    }
    if let Some(why) = never(term) {
        return Some(why.into());
    }
    if term.scope == Scope::Recording && !options.keep.contains(&term.effect) {
        let why = "it holds on the recording that it was found in only";
        let keep = match since_start {
            true => format!(
                "; where the routine begins as that recording did, at switch-on, {} can be kept",
                term.effect
            ),
            false => String::new(),
        };
        return Some(format!("{why}{keep}"));
    }
    (beyond && !term.operator.extrapolates()).then(|| "it is not known beyond the recording".into())
}

/// Whether a saturating exponential is one of the time since the routine began, which it counts itself.
pub(crate) fn by_time(exponential: &Exponential, further: &[Further]) -> bool {
    exponential.observable == TIME && !further.iter().any(|f| f.observable == TIME)
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
    let refuse =
        |why: &str| Err(PhysicsError::NotGenerated { effect: effect.clone(), kind, why: why.into() });
    let needs_period = || PhysicsError::NeedsPeriod { effect: effect.clone(), kind };
    match &term.operator {
        Operator::Exponential(e) if by_time(e, &options.further) => {
            if e.start > 0.0 {
                return refuse(": it begins later than the routine does");
            }
            return options.period_s.map(|_| ()).ok_or_else(needs_period);
        }
        Operator::Step(step) if of_reading(&step.observable) => {
            return refuse(": at a step of the reading itself no bound is small");
        }
        _ => {}
    }
    let mut observables = term.operator.observables();
    if matches!(term.operator, Operator::Lag(_) | Operator::Rate(_)) {
        // The time is that of the calls.
        observables.truncate(1);
    }
    if let Operator::Expression(_) = &term.operator {
        if observables.contains(&"pass") {
            return refuse(": firmware does not know the number of a pass");
        }
        // Of what remembers, the time is that of the calls; where the time is a column, the lowering asks for it.
        observables.retain(|name| *name != TIME);
    }
    if let Some(name) = observables.into_iter().find(|name| !of_reading(name) && !given(name)) {
        return Err(PhysicsError::Needs { effect, kind, observable: name.into() });
    }
    let is_pair = matches!(sensor, Sensor::EddyCurrentPair { .. });
    let timed = Tree::of_term(term, is_pair).is_ok_and(|tree| tree.needs_period());
    if timed && options.period_s.is_none() {
        return Err(needs_period());
    }
    Ok(())
}

/// Terms that cannot hold together.
fn contradiction(terms: &[Term]) -> Result<(), PhysicsError> {
    let mut means: Vec<(&str, f64, &str)> = Vec::new();
    for (i, term) in terms.iter().enumerate() {
        let same = |other: &&Term| other.effect == term.effect && other.operator == term.operator;
        if terms[..i].iter().any(|other| same(&other)) {
            let (effect, kind) = (term.effect.clone(), term.operator.kind());
            return Err(PhysicsError::Twice { effect, kind });
        }
        let counted: Vec<(&str, f64)> = match &term.operator {
            Operator::Product(p) => p.factors.iter().map(|f| (f.observable.as_str(), f.mean)).collect(),
            Operator::Lag(lag) => vec![(lag.observable.as_str(), lag.mean)],
            _ => Vec::new(),
        };
        for (observable, mean) in counted {
            match means.iter().find(|(name, ..)| *name == observable) {
                Some((_, other, first)) if (other - mean).abs() > 1e-9 * (1.0 + mean.abs()) => {
                    return Err(PhysicsError::Means {
                        observable: observable.into(),
                        first: (*first).into(),
                        second: term.effect.clone(),
                        means: (*other, mean),
                    });
                }
                Some(_) => {}
                None => means.push((observable, mean, &term.effect)),
            }
        }
    }
    Ok(())
}
