//! What of the coefficients of a whole turn repeats with the turn, and what does not: a routine that is given a count
//! alone corrects the former, and names the latter with its size.

use fitter::coefficients::Coefficients;
use fitter::terms::{Operator, Product, Scope, Term};

use super::TurnError;
use crate::extent::LeftOut;

/// How near a number of periods in a turn has to be to a whole one: far above what `f64` rounds of their quotient, far
/// below what a fitted period is known to.
const WHOLE: f64 = 1e-12;

/// The two parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Wraps {
    /// The constant, in the sensor's unit.
    pub zero: f64,
    /// Harmonics: their number in a turn, coefficients of cosine and sine.
    pub waves: Vec<(u32, f64, f64)>,
    /// The periodic terms of which the harmonics are, by their number in the file.
    pub terms: Vec<usize>,
    /// What does not repeat.
    pub left_out: Vec<LeftOut>,
}

impl Wraps {
    /// Of coefficients of a whole turn.
    ///
    /// # Errors
    /// [`TurnError`] where they are of no whole turn, or have a curve instead of harmonics.
    pub fn of(file: &Coefficients) -> Result<Wraps, TurnError> {
        let turn = file.turn.as_ref().filter(|turn| turn.whole).ok_or(TurnError::NotATurn)?;
        let order = file.base.coefficients.len().saturating_sub(1);
        if order > 1 {
            return Err(TurnError::Polynomial { order });
        }
        let range = (turn.from, turn.from + turn.revolution);
        let middle = turn.from + 0.5 * turn.revolution;
        let mut wraps = Wraps {
            zero: file.base.coefficients.first().copied().unwrap_or(0.0),
            waves: Vec::new(),
            terms: Vec::new(),
            left_out: Vec::new(),
        };
        let unit = &file.units.statistics;
        if let Some(slope) = file.base.coefficients.get(1).copied().filter(|slope| *slope != 0.0) {
            let what = "slope of the error over the turn";
            wraps.leave_slope(what, slope, file.base.centre, (middle, range), unit);
        }
        for (index, term) in file.terms.iter().enumerate() {
            match &term.operator {
                Operator::Periodic(periodic) => match whole(turn.revolution / periodic.period) {
                    Some(periods) => {
                        let waves = periodic.harmonics.iter().zip(term.coefficients.chunks_exact(2));
                        let wave = |(k, pair): (&u16, &[f64])| (periods * u32::from(*k), pair[0], pair[1]);
                        wraps.waves.extend(waves.map(wave));
                        wraps.terms.push(index);
                    }
                    None => wraps.leave(term, file, range, "its period is no part of the turn"),
                },
                Operator::Product(product) if is_slope(product) => {
                    let factor = &product.factors[0];
                    let (slope, mean) = (term.coefficients[0], factor.mean);
                    wraps.leave_slope(&term.effect, slope, mean, (middle, range), unit);
                }
                _ => wraps.leave(term, file, range, why(term)),
            }
        }
        Ok(wraps)
    }

    fn leave(&mut self, term: &Term, file: &Coefficients, range: (f64, f64), why: &str) {
        self.left_out.push(LeftOut::of(term, file, range, why, term.scope == Scope::Device));
    }

    /// A slope does not wrap, but its value in the middle of the turn is a constant like any other.
    fn leave_slope(
        &mut self,
        effect: &str,
        slope: f64,
        at: f64,
        (middle, range): (f64, (f64, f64)),
        unit: &str,
    ) {
        self.zero += slope * (middle - at);
        let size = slope.abs() * 0.5 * (range.1 - range.0);
        self.left_out.push(LeftOut {
            effect: effect.into(),
            why: format!(
                "it does not repeat with the turn, but for its middle; it is {:+.2e} {unit} a turn, up to {size:.2e} {unit} \
                 from the middle",
                slope * (range.1 - range.0)
            ),
            size: Some(size),
        });
    }
}

fn is_slope(product: &Product) -> bool {
    matches!(&product.factors[..], [only] if only.observable == "measured" && only.power == 1)
}

/// The whole number that a quotient is.
fn whole(quotient: f64) -> Option<u32> {
    let nearest = quotient.round();
    let near = (quotient - nearest).abs() <= WHOLE * nearest;
    // Harmonics of a turn are far fewer than the counts of any encoder.
    (near && (1.0..=65536.0).contains(&nearest)).then_some(nearest as u32)
}

fn why(term: &Term) -> &'static str {
    match (&term.operator, term.scope) {
        (_, Scope::Recording) => "it belongs to the recording, not to the device",
        (Operator::Play(_), _) => "a count alone does not tell from which side it was reached",
        (Operator::Rate(_), _) => "a count alone does not tell the speed",
        _ => "it does not depend on the count alone",
    }
}
