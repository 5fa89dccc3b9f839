//! How far an effect that follows slowly had come before the first row, or before a pause, no recording says. What is missing
//! is fitted: a further amplitude for each such time, which fades with the effect's time constant. It belongs to the recording.

use fitter::terms::{Expressed, ExpressionFactor};
use physics::{MISSING, Since, Unit};

use super::Effect;
use crate::rows::Rows;

impl Effect {
    /// Since when it is not known how far it had come, and the parameter with which that fades; none where it is.
    fn unsettled(&self) -> Option<(Since, usize)> {
        let unsettled = self.made.declared.known.unsettled.as_ref()?;
        let of_name = |index: &usize| self.parameter(*index).name == unsettled.fades_with;
        Some((unsettled.since, self.made.shaped.iter().position(of_name)?))
    }

    /// Times in seconds before which nothing is known: that of the first row, and the middle of every pause if it is unsettled by
    /// pauses.
    fn unknown_before(&self, rows: &Rows) -> Vec<f64> {
        let first = rows.t_s.first().copied();
        match self.unsettled() {
            None => Vec::new(),
            Some((Since::Start, _)) => first.into_iter().collect(),
            Some((Since::Pauses, _)) => first.into_iter().chain(rows.pauses_s.iter().copied()).collect(),
        }
    }

    /// How many of its columns are its own, the first ones, where the others are what is missing; none where there are no others.
    pub fn own_columns(&self) -> Option<usize> {
        self.unsettled().map(|_| self.factors().count())
    }

    /// Whether the recording has the pauses after which it would be unsettled.
    pub(super) fn may_be_unsettled(&self, rows: &Rows) -> bool {
        !matches!(self.unsettled(), Some((Since::Pauses, _))) || !rows.pauses_s.is_empty()
    }

    /// A column over the rows for each of these times: 1 at it, fading after it, 0 before it.
    pub(super) fn missing(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let Some((_, fades)) = self.unsettled() else { return Vec::new() };
        let unit = &self.parameter(self.made.shaped[fades]).unit;
        let tau_s = shape[fades] * unit.in_units_of(&Unit::named("s")).unwrap_or(f64::NAN);
        let fading = |since: &f64| {
            let at = |t: &f64| if t < since { 0.0 } else { (-(t - since) / tau_s).exp() };
            rows.t_s.iter().map(at).collect()
        };
        self.unknown_before(rows).iter().map(fading).collect()
    }

    /// An expression of the effect in a recording with what is missing there.
    pub(super) fn with_missing(&self, settled: Expressed, rows: &Rows) -> Expressed {
        let Some((_, fades)) = self.unsettled() else { return settled };
        let (tau, times) = (&self.parameter(self.made.shaped[fades]).name, self.unknown_before(rows));
        let mut text = settled.text.clone();
        let mut factors = settled.factors.clone();
        for (k, since) in times.iter().enumerate() {
            text += &format!(
                " + {} * step(t_s, {since} [s]) * exp(-hinge(t_s, {since} [s]) / {tau})",
                missing(k)
            );
            factors.push(ExpressionFactor { name: missing(k), unit: rows.unit.clone() });
        }
        Expressed::of(text, &rows.unit, self.made.pair, factors, settled.parameters)
    }

    /// An expression of the effect without what is missing in the recording that it was made for.
    pub(crate) fn without_missing(&self, here: &Expressed) -> Expressed {
        let own = self.factors().count();
        let settled = here.text.split_once(&format!(" + {} ", missing(0)));
        let Some((text, _)) = settled.filter(|_| self.unsettled().is_some()) else { return here.clone() };
        let factors = here.factors[..own].to_vec();
        let settled =
            Expressed::of(text.into(), &here.unit, self.made.pair, factors, here.parameters.clone());
        Expressed { limits: here.limits.clone(), ..settled }
    }
}

/// The name of a factor of what is missing.
fn missing(k: usize) -> String {
    format!("{MISSING}{}", k + 1)
}
