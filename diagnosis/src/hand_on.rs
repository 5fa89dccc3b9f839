//! The augmented model as a coefficients file, which `apply` and `generate` read.

mod limits;
mod mean;
mod other_recordings;

use std::collections::BTreeMap;

use fitter::coefficients::{Coefficients, Provenance, VERSION_EXPRESSION, VERSION_TURN};
use fitter::error_model::ErrorModel;
use fitter::terms::{Observables, Operator, Periodic, Scope, Term, depends_on_angle};
use fitter::turn::{Amplitude, Turn};
use fitter::{Mirror, Recording};
use numerics::{least_squares, mean, range};

use crate::effects::{Effect, Reading};
use crate::explain::Outset;
use crate::model::{FittedTerm, Model};
use crate::refit;
use crate::rows::Rows;
use crate::screened::Seen;
use crate::thresholds::hand_on::MARGIN;
use crate::undecided::Weighted;

/// Everything that turns a model of a recording into what is handed on, and counts what that leaves.
pub struct HandOn<'a> {
    /// The recording, and how `apply` will see it.
    pub seen: Seen<'a>,
    /// The nominal mirror.
    pub mirror: &'a Mirror,
    /// Every row of it.
    pub full: &'a Rows,
    /// The rows that were searched.
    pub rows: &'a Rows,
    /// What their explanations start from.
    pub outset: &'a Outset,
    /// The row that was searched for every row of the recording.
    pub cell_of: &'a [usize],
    /// The effects.
    pub catalogue: &'a [Effect],
    /// Most harmonics of a periodic error.
    pub harmonics: Option<usize>,
    /// The command that stands in the file.
    pub command: &'a str,
    /// Whether the recording is compared with the user's own simulation, which no coefficients file holds.
    pub simulated: bool,
}

impl HandOn<'_> {
    /// The coefficients file of a model that was refitted, as `apply` accepts it.
    ///
    /// # Errors
    /// The sentence with which `apply` would refuse the file.
    pub fn file(&self, refitted: &Coefficients, model: &Model) -> Result<Coefficients, String> {
        let mut file = refitted.clone();
        self.share_out(&mut file, model);
        accepted(file)
    }

    /// The same of the mean of such a model and others.
    ///
    /// # Errors
    /// As of [`HandOn::file`].
    pub fn mean(
        &self,
        refitted: &Coefficients,
        model: &Model,
        others: &[Weighted],
    ) -> Result<Coefficients, String> {
        let file = self.file(refitted, model)?;
        if others.is_empty() { Ok(file) } else { accepted(mean::mean(&file, others)) }
    }

    /// The order of the base that `fit` chooses for this recording; none where it was given, where a turn repeats, where
    /// the error is that of the user's own simulation, and where nothing can be held out.
    pub fn order_of_fit(&self) -> Option<usize> {
        if self.rows.order.is_some() || self.rows.whole_turn().is_some() || self.simulated {
            return None;
        }
        let chosen = fitter::choose_order(self.seen.recording, self.mirror, &fitter::Options::default());
        chosen.ok().map(|selection| selection.chosen)
    }

    /// The model fitted where it is used, one term per effect. `held` marks the searched rows that take no part.
    pub fn refitted(&self, model: &Model, held: Option<&[bool]>) -> Coefficients {
        let mut file = self.as_searched(model);
        describe(&mut file, self.full);
        if let Some(most) = self.harmonics {
            refit::keep_strongest(&mut file, most);
        }
        let used: Vec<bool> = self.cell_of.iter().map(|cell| held.is_none_or(|held| !held[*cell])).collect();
        refit::refit(&mut file, &self.seen, self.full, &used, self.rows.len(), self.harmonics);
        file
    }

    /// The parameters of every effect of a model as it was refitted, in the order of the terms; none of an effect of
    /// which other harmonics are handed on than were fitted.
    pub fn parameters(&self, refitted: &Coefficients, model: &Model) -> Vec<Option<Vec<Reading>>> {
        let named: Vec<(&FittedTerm, usize)> =
            model.terms.iter().filter_map(|term| Some((term, term.effect?))).collect();
        let handed = &refitted.terms[refitted.terms.len() - named.len()..];
        let readings = |((term, e), handed): (&(&FittedTerm, usize), &Term)| {
            let (effect, shape) = (&self.catalogue[*e], &term.term.shape);
            let map = effect.operator(self.rows, shape).map;
            let by_amplitude: Vec<Vec<f64>> =
                (0..term.amplitudes.len()).map(|k| map.iter().map(|row| row[k]).collect()).collect();
            (map.len() == handed.coefficients.len()).then(|| {
                let amplitudes = least_squares(&by_amplitude, &handed.coefficients).coefficients;
                effect.readings(self.rows, shape, &amplitudes)
            })
        };
        named.iter().zip(handed).map(readings).collect()
    }

    /// What the handed-on model leaves of every row of the recording, less the mean over the rows that were fitted;
    /// none where `apply` would refuse it.
    pub fn left(&self, model: &Model, held: Option<&[bool]>) -> Option<Vec<f64>> {
        let refitted = (!self.simulated).then(|| self.refitted(model, held));
        self.left_by(refitted.as_ref(), model, held)
    }

    /// The same of a model that was refitted.
    pub fn left_by(
        &self,
        refitted: Option<&Coefficients>,
        model: &Model,
        held: Option<&[bool]>,
    ) -> Option<Vec<f64>> {
        let mut left: Vec<f64> = match refitted.filter(|_| !self.simulated) {
            Some(refitted) => refit::errors(&self.file(refitted, model).ok()?, &self.seen, self.full)?,
            None => {
                let value = model.value();
                self.full.error.iter().zip(self.cell_of).map(|(error, cell)| error - value[*cell]).collect()
            }
        };
        let fitted = left.iter().zip(self.cell_of).filter(|(_, cell)| held.is_none_or(|h| !h[**cell]));
        let offset = mean(&fitted.map(|(left, _)| *left).collect::<Vec<f64>>());
        left.iter_mut().for_each(|left| *left -= offset);
        left.iter().all(|left| left.is_finite()).then_some(left)
    }

    /// The file of a model as it was searched. Generic terms are left out: they are no physics that would hold anywhere
    /// else.
    fn as_searched(&self, model: &Model) -> Coefficients {
        let mut parts = self.of_base(model);
        let mut first = model.base.len();
        for term in &model.terms {
            let begin = first;
            first += term.amplitudes.len();
            if let Some(e) = term.effect {
                self.add_term(&mut parts, &self.catalogue[e], term, begin);
            }
        }
        let Parts { mut file, linear, .. } = parts;
        file.joint_covariance = propagated(&linear, &model.covariance);
        file.observed = observed(self.seen.recording, self.mirror, &file.terms);
        file
    }

    /// The base: of a whole turn a constant and a term of harmonics.
    fn of_base(&self, model: &Model) -> Parts {
        let (rows, mirror, recording) = (self.rows, self.mirror, self.seen.recording);
        let (centre, half) = rows.reading_scale();
        let per = mirror.sensor.per_internal();
        let scale = 1.0 / mean(&rows.weight) / per;
        let turn = rows.turn.as_ref().filter(|turn| turn.whole);
        let of_polynomial = if turn.is_some() { 1 } else { model.base.len() };
        let (powers, alpha0) = powers_and_zero(&model.base[..of_polynomial], half, scale, mirror);
        // By columns what was fitted, for the covariance.
        let fitted = model.base.len() + model.terms.iter().map(|t| t.amplitudes.len()).sum::<usize>();
        let mut linear = vec![vec![0.0; fitted]; powers.len()];
        for k in 0..of_polynomial {
            let mut unit = vec![0.0; of_polynomial];
            unit[k] = 1.0;
            let column = powers_and_zero(&unit, half, scale, mirror).0;
            linear.iter_mut().zip(column).for_each(|(row, value)| row[k] = value);
        }
        let centre = turn.map_or(centre, |turn| turn.from + 0.5 * turn.revolution);
        let error_model = ErrorModel { sensor: mirror.sensor.clone(), centre, coefficients: powers };
        let (from, to) = turn.map_or(range(&rows.reading), |turn| (turn.from, turn.from + turn.revolution));
        let mut file = Coefficients::of_model(&error_model, from, to, self.command);
        if let Some(turn) = &rows.turn {
            file.version = VERSION_TURN;
            file.turn = Some(Turn { amplitudes: Vec::new(), ..turn.clone() });
        }
        file.tool = format!("diagnose {}", env!("CARGO_PKG_VERSION"));
        file.recording =
            Provenance { file: recording.file.clone(), sha256: recording.sha256.clone(), rows: 0, passes: 0 };
        describe(&mut file, rows);
        if let Some(turn) = turn.filter(|_| model.base.len() > 1) {
            let (waves, n) = (&model.base[1..], model.base.len());
            let row = |i| (1..n).map(|k| model.covariance[i * fitted + k]).collect();
            linear.extend((1..n).map(|k| (0..fitted).map(|i| f64::from(u8::from(i == k))).collect()));
            file.terms.push(Term {
                effect: physics::found_by_fit("harmonics"),
                scope: Scope::Device,
                operator: Operator::Periodic(Periodic::of(turn.revolution, (waves.len() / 2) as u16)),
                coefficients: waves.to_vec(),
                covariance: (1..n).map(row).collect(),
            });
        }
        // The true angle counted from α₀, as a coefficients file counts it.
        let truth = rows.truth.iter().map(|t| t - alpha0 * per).collect();
        Parts { file, linear, fitted, rows: Rows { truth, ..rows.clone() } }
    }

    /// Adds an effect whose first amplitude is number `begin` of what was fitted.
    fn add_term(&self, parts: &mut Parts, effect: &Effect, term: &FittedTerm, begin: usize) {
        let mut handed = effect.operator(&parts.rows, &term.term.shape);
        let coefficients: Vec<f64> =
            handed.map.iter().map(|row| row.iter().zip(&term.amplitudes).map(|(m, a)| m * a).sum()).collect();
        if let Operator::Expression(expressed) = &mut handed.operator {
            parts.file.version = VERSION_EXPRESSION;
            if effect.is_form() {
                let columns = effect.further_columns();
                expressed.limits = limits::limits(expressed, &coefficients, &columns, &parts.rows);
            }
        }
        let width = term.amplitudes.len();
        let product = |left: &[f64], right: &[f64]| -> f64 {
            (0..width * width).map(|k| left[k / width] * term.covariance[k] * right[k % width]).sum()
        };
        let row = |left: &Vec<f64>| handed.map.iter().map(|right| product(left, right)).collect();
        let covariance = handed.map.iter().map(row).collect();
        for row in &handed.map {
            let mut whole = vec![0.0; parts.fitted];
            whole[begin..begin + width].copy_from_slice(&row[..width]);
            parts.linear.push(whole);
        }
        parts.file.terms.push(Term {
            effect: effect.id.clone(),
            scope: if effect.of_one_time { Scope::Recording } else { Scope::Device },
            operator: handed.operator,
            coefficients,
            covariance,
        });
    }
}

/// A file as `apply` accepts it.
///
/// # Errors
/// The sentence with which `apply` would refuse it.
fn accepted(mut file: Coefficients) -> Result<Coefficients, String> {
    if let Some(turn) = &mut file.turn {
        turn.amplitudes = amplitudes(&file.terms, turn.revolution);
    }
    match fitter::acceptance::to_apply(&file) {
        Ok(()) => Ok(file),
        Err(refusal) => Err(refusal.to_string()),
    }
}

/// A file in the making.
struct Parts {
    file: Coefficients,
    /// The file's coefficients as linear in what was fitted, a row each.
    linear: Vec<Vec<f64>>,
    /// How much was fitted.
    fitted: usize,
    /// The rows with the true angle counted as the file counts it.
    rows: Rows,
}

/// The harmonics of the turn as amplitude and phase.
fn amplitudes(terms: &[Term], revolution: f64) -> Vec<Amplitude> {
    let of_turn = terms.iter().find_map(|term| match &term.operator {
        Operator::Periodic(periodic) if periodic.period == revolution => Some((periodic, &term.coefficients)),
        _ => None,
    });
    let one = |(harmonic, pair): (&u16, &[f64])| Amplitude {
        harmonic: *harmonic,
        amplitude: pair[0].hypot(pair[1]),
        phase_deg: pair[1].atan2(pair[0]).to_degrees(),
        standard_error: None,
    };
    of_turn.map_or_else(Vec::new, |(p, c)| p.harmonics.iter().zip(c.chunks_exact(2)).map(one).collect())
}

/// The polynomial of Eq. 5 from the Legendre series of the base, and α₀ in internal units: both linear in the series.
fn powers_and_zero(series: &[f64], half: f64, scale: f64, mirror: &Mirror) -> (Vec<f64>, f64) {
    // Legendre series in x = (reading − centre)/half to powers of (reading − centre).
    let mut powers: Vec<f64> = monomials(series).iter().map(|c| c * scale).collect();
    for (k, power) in powers.iter_mut().enumerate() {
        *power /= half.powi(k as i32);
    }
    let fitter::error_model::Sensor::EddyCurrentPair { probe_distance_mm: d, .. } = &mirror.sensor else {
        return (powers, 0.0);
    };
    // The error is zero at calculated angle 0 (Eq. 7): α₀ in radians, a constant angle, is
    // α₀ (s² + d²)/d in the bracket of Eq. 6.
    let alpha0 = -powers[0] / d;
    while powers.len() < 3 {
        powers.push(0.0);
    }
    powers[0] += alpha0 * d;
    powers[2] += alpha0 / d;
    (powers, alpha0)
}

/// L C Lᵀ of a square C, given by rows.
fn propagated(linear: &[Vec<f64>], covariance: &[f64]) -> Vec<Vec<f64>> {
    let n = linear.first().map_or(0, Vec::len);
    let right: Vec<Vec<f64>> = linear
        .iter()
        .map(|row| (0..n).map(|i| (0..n).map(|k| covariance[i * n + k] * row[k]).sum()).collect())
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum();
    // Both halves from one, so that the matrix is symmetric to the last digit.
    let entry = |i: usize, j: usize| dot(&linear[i.max(j)], &right[i.min(j)]);
    (0..linear.len()).map(|i| (0..linear.len()).map(|j| entry(i, j)).collect()).collect()
}

/// What the recording covers of the observables that the terms read beside the reading, with the margin that the
/// reading has ([`describe`]).
fn observed(recording: &Recording, mirror: &Mirror, terms: &[Term]) -> BTreeMap<String, [f64; 2]> {
    let observables = Observables { recording, sensor: &mirror.sensor };
    let names = terms.iter().flat_map(|term| term.operator.observables());
    let covered = |name: &str| {
        let values = observables.get(name).ok()?;
        let known: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
        Some((name.to_string(), wider(&known, MARGIN)))
    };
    names.filter(|name| !depends_on_angle(name)).filter_map(covered).collect()
}

/// The range of values, wider on both sides by a part of it.
fn wider(values: &[f64], part: f64) -> [f64; 2] {
    let (from, to) = range(values);
    let margin = part * (to - from);
    [from - margin, to + margin]
}

/// Says how much was recorded and over which range.
fn describe(file: &mut Coefficients, rows: &Rows) {
    let (from, to) = range(&rows.reading);
    // The next recording's outermost rows miss these by the controller's jitter, and must not fall to the
    // extrapolation for it.
    let margin = MARGIN * (to - from);
    if !file.whole_turn() {
        (file.valid_range.from, file.valid_range.to) = (from - margin, to + margin);
    }
    file.recording.rows = rows.len();
    file.recording.passes = rows.passes().len();
}

/// Powers of x from a Legendre series, by the recurrence of the polynomials themselves.
fn monomials(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    let mut out = vec![0.0; n];
    let (mut before, mut now) = (vec![0.0; n], vec![0.0; n]);
    now[0] = 1.0;
    for (k, c) in series.iter().enumerate() {
        for (o, p) in out.iter_mut().zip(&now) {
            *o += c * p;
        }
        let kf = k as f64;
        let mut next = vec![0.0; n];
        for j in 0..n {
            if j > 0 {
                next[j] += (2.0 * kf + 1.0) * now[j - 1];
            }
            next[j] = (next[j] - kf * before[j]) / (kf + 1.0);
        }
        before = std::mem::replace(&mut now, next);
    }
    out
}
