//! All terms of a coefficients file over a recording.

use super::{Missing, Observables, Operator, Periodic, Scope, Term, periodic};

/// What the terms add, apart from the periodic ones, which need the rest of the correction first.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluated {
    /// Sum of the explicit terms row by row, inside the calibrated range, in the unit of the statistics.
    pub inside: Vec<f64>,
    /// The same with only the terms that extrapolate.
    pub outside: Vec<f64>,
    /// Terms that were left out because the recording has not their column: effect and column.
    pub missing: Vec<(String, Missing)>,
    /// Effects left out because they hold on the recording they were found in only.
    pub other_recording: Vec<String>,
    /// Terms left out on some rows, because a cell is blank: effect and number of rows.
    pub blank: Vec<(String, usize)>,
    periodic: Vec<(Periodic, Vec<f64>)>,
}

/// Evaluates terms over a recording. `same_recording` tells whether it is the one they were found in;
/// otherwise terms of [`Scope::Recording`] are left out.
pub fn evaluate(terms: &[Term], observables: &Observables, same_recording: bool) -> Evaluated {
    let rows = observables.recording.rows();
    let mut result = Evaluated {
        inside: vec![0.0; rows],
        outside: vec![0.0; rows],
        missing: Vec::new(),
        other_recording: Vec::new(),
        blank: Vec::new(),
        periodic: Vec::new(),
    };
    for term in terms {
        if term.scope == Scope::Recording && !same_recording {
            result.other_recording.push(term.effect.clone());
            continue;
        }
        if let Operator::Periodic(periodic) = &term.operator {
            result.periodic.push((periodic.clone(), term.coefficients.clone()));
            continue;
        }
        let columns = match term.operator.columns(observables) {
            Ok(columns) => columns,
            Err(missing) => {
                result.missing.push((term.effect.clone(), missing));
                continue;
            }
        };
        let extrapolates = term.operator.extrapolates();
        let mut blank = 0;
        for row in 0..rows {
            let value: f64 = columns.iter().zip(&term.coefficients).map(|(column, c)| c * column[row]).sum();
            if value.is_nan() {
                blank += 1;
                continue;
            }
            result.inside[row] += value;
            if extrapolates {
                result.outside[row] += value;
            }
        }
        if blank > 0 {
            result.blank.push((term.effect.clone(), blank));
        }
    }
    result
}

impl Evaluated {
    /// Over `rows` rows, of which it was evaluated over the ascending `kept`: each other has the terms of the row kept
    /// before it, or of the first.
    pub fn spread(self, kept: &[usize], rows: usize) -> Evaluated {
        let held = |values: &[f64]| -> Vec<f64> {
            let at = |row: usize| kept.partition_point(|kept| *kept <= row).saturating_sub(1);
            (0..rows).map(|row| values.get(at(row)).copied().unwrap_or(0.0)).collect()
        };
        Evaluated { inside: held(&self.inside), outside: held(&self.outside), ..self }
    }

    /// It and others.
    pub fn and(mut self, others: Evaluated) -> Evaluated {
        let add =
            |sum: &mut [f64], more: &[f64]| sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        add(&mut self.inside, &others.inside);
        add(&mut self.outside, &others.outside);
        self.missing.extend(others.missing);
        self.other_recording.extend(others.other_recording);
        self.blank.extend(others.blank);
        self.periodic.extend(others.periodic);
        self
    }

    /// The corrected angle Θ, given θ less all other errors: Θ + Σ periodic(Θ) = `observed`.
    pub fn solve_periodic(&self, observed: f64) -> f64 {
        if self.periodic.is_empty() {
            return observed;
        }
        let terms: Vec<(&Periodic, &[f64])> =
            self.periodic.iter().map(|(periodic, c)| (periodic, c.as_slice())).collect();
        periodic::solve(&terms, observed)
    }
}
