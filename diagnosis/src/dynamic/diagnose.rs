//! One dynamic recording from rows to everything that is said of it.

use std::sync::Arc;

use fitter::plant::{Kind, PlantFile};
use fitter::table::Values;
use motion::equations::MotionEffect;
use numerics::{Symmetric, parallel};

use super::accurate::estimated_or_coarse;
use super::data::{ALL, CHOOSE_ROWS, Data, FIT_ROWS, UNSCORED};
use super::estimate::{Fitted, fit};
use super::joint::equations::InEquations;
use super::joint::feedback::Inverse;
use super::judge::{self, Problem, Withdrawn};
use super::linear::looped::Looped;
use super::model::{Model, Term};
use super::noise::autoregression;
use super::recording::DynamicRecording;
use super::score;
use super::search::{Search, gain};
use super::structure::{Structure, structure};
use super::verdict::{self, Left};
use super::{equations, expected, feedback, floor, linear, plant, remainder};
use crate::DiagnosisError;
use crate::diagnosis::{Diagnosis, NoiseFloor};
use crate::held_out::Fit;
use crate::thresholds::dynamic::diagnose::{SEARCH_STEPS, START_ROWS};
use crate::thresholds::dynamic::effects::HARD;
use crate::thresholds::dynamic::search::LEAST_GAIN;
use crate::verdict::{Said, Verdict};

/// What a dynamic diagnosis is asked for.
#[derive(Clone, Default)]
pub struct Options {
    /// Ids of effects that are left out of the catalogue.
    pub skip: Vec<String>,
    /// Effects that the nominal plant has: they are fitted with it, and not in question.
    pub given: Vec<Term>,
    /// The user's own effects, in a plant in equations.
    pub own: Vec<Arc<MotionEffect>>,
    /// Under feedback the frequency up to which the motion is looked at, Hz; that which predicts best where none is given.
    pub cutoff_hz: Option<f64>,
    /// Under feedback: the recording is held against another one of the same motion, along which what is left of structure is
    /// the same. Standard errors are then those of the noise.
    pub same_motion: bool,
}

/// Predictions row for row, one column per position.
#[derive(Debug, Clone, Default)]
pub struct Predicted {
    /// Time, s.
    pub t_s: Values,
    /// By the nominal plant (or the user's simulation).
    pub before: Vec<Vec<f64>>,
    /// By the augmented plant.
    pub after: Vec<Vec<f64>>,
}

impl Predicted {
    /// Those of a recording by the model before and the one after.
    pub(crate) fn by<M: Sync>(
        recording: &DynamicRecording,
        [before, after]: [&M; 2],
        columns: impl Fn(&M) -> Vec<Vec<f64>> + Sync,
    ) -> Predicted {
        let (before, after) = parallel::join(|| columns(before), || columns(after));
        Predicted { t_s: recording.t_s.clone(), before, after }
    }
}

/// A dynamic diagnosis with what its files are made from.
pub struct DynamicOutcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The augmented plant.
    pub plant: PlantFile,
    /// Predictions of the recording itself.
    pub own: Predicted,
    /// Predictions of the held-out recording.
    pub other: Option<Predicted>,
    /// An effect that changes what is predicted of the rows that score, and does not improve it.
    pub idle: Option<String>,
    /// The augmented plant as it was fitted, for a comparison with another recording.
    pub(crate) identified: Identified,
}

/// What a recording identified.
pub(crate) enum Identified {
    /// A mechanism that runs free.
    SecondOrder(Box<Model>),
    /// A plant in equations.
    Equations(Box<InEquations>),
    /// An inverse model.
    Inverse(Inverse),
    /// A structure of many modes.
    Modes(Box<Looped>),
}

/// The user's own simulation of a recording.
#[derive(Debug, Clone)]
pub struct OwnSimulation {
    /// Name of its file.
    pub file: String,
    /// The predicted positions, row for row.
    pub positions: Vec<f64>,
}

impl OwnSimulation {
    /// Refuses a simulation of other rows than a recording's.
    ///
    /// # Errors
    /// [`DiagnosisError::Rows`].
    pub fn of_rows(&self, rows: usize) -> Result<(), DiagnosisError> {
        match self.positions.len() {
            found if found == rows => Ok(()),
            found => Err(self.wrong(format!("{found} rows"), format!("{rows} rows"))),
        }
    }

    /// A recording with the simulated position in the place of the measured one.
    ///
    /// # Errors
    /// As [`OwnSimulation::of_rows`].
    pub fn in_place(&self, recording: &DynamicRecording) -> Result<DynamicRecording, DiagnosisError> {
        self.of_rows(recording.rows())?;
        Ok(DynamicRecording { positions: vec![self.positions.clone().into()], ..recording.clone() })
    }

    /// The error of a simulation that is something else than was expected.
    pub fn wrong(&self, found: String, expected: String) -> DiagnosisError {
        DiagnosisError::Rows { file: self.file.clone(), found, expected }
    }
}

/// One dynamic recording and what it is diagnosed with.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// The recording.
    pub recording: &'a DynamicRecording,
    /// The nominal plant.
    pub plant: &'a PlantFile,
    /// Its file's name in messages.
    pub plant_file: &'a str,
    /// The user's own simulation of the recording.
    pub simulated: Option<&'a OwnSimulation>,
    /// Another recording of the same device, for the held-out figures.
    pub held_out: Option<&'a DynamicRecording>,
    /// What is asked for.
    pub options: &'a Options,
}

impl Case<'_> {
    /// What is said of the recording before it is held against itself.
    pub(crate) fn said(&self, said: Said, floor: NoiseFloor, fit: Fit) -> Diagnosis {
        let bad_rows = self.recording.bad_rows.clone();
        Diagnosis { bad_rows, ..Diagnosis::of(&self.recording.file, said, floor, fit) }
    }
}

/// Diagnoses one recording.
///
/// # Errors
/// One of [`DiagnosisError`]: the recording cannot be diagnosed at all.
pub fn diagnose(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    let Case { recording, plant, .. } = *case;
    let linear = plant.plant.kind == Kind::Linear;
    if plant.plant.kind == Kind::Equations {
        if let Some(other) = case.held_out {
            recording.comparable(other)?;
        }
        return equations::diagnose(case);
    }
    if !linear && (recording.drives.len() != 1 || recording.positions.len() != 1) {
        return Err(DiagnosisError::Channels {
            file: recording.file.clone(),
            found: recording.drives.len(),
            positions: recording.positions.len(),
        });
    }
    if let Some(other) = case.held_out {
        recording.comparable(other)?;
    }
    if !linear && !case.options.own.is_empty() {
        return equations::second_order::diagnose(case);
    }
    match plant.plant.feedback {
        _ if linear => linear::diagnose::diagnose(case),
        Some(_) => feedback::diagnose(case),
        None => free_run(case).map(|first| equations::described(case, first)),
    }
}

/// Diagnoses a mechanism of one axis that runs free.
fn free_run(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    let Case { recording, simulated, options, .. } = *case;
    let data = Data::new(recording);
    let lost = || recording.lost(100.0);
    let seen = expected::nominal(recording, &data.windows(START_ROWS), simulated, &options.given)?;
    let windows = data.windows(SEARCH_STEPS / seen.model.substeps(data.step_s));
    let seen = fit(&seen.model, &windows.first_states(), &windows, ALL).ok_or_else(lost)?;
    let search = Search::new(&windows, &options.skip, seen.model.terms.len());
    let mut chosen = search.with_rare_saturation(search.settled(search.run(&seen)));
    if windows.count(ALL) < data.count(ALL) {
        chosen = decided(&search, &data, chosen);
    }
    let nominal_model = seen.model.clone();
    let (before, found) = parallel::join(|| whole(&data, &nominal_model), || whole(&data, &chosen.model));
    let (before, found) = (before.ok_or_else(lost)?, found.ok_or_else(lost)?);
    let creeps = chosen.model.terms.iter().any(|t| t.effect.creep().is_some_and(|k| t.free[k]));
    judge::standing(&FreeRun { case, data: &data, search: &search, seen, before, chosen, found, creeps })
}

/// A model on the whole recording: its initial states follow from the first rows. None where it runs away.
fn whole(data: &Data, model: &Model) -> Option<Fitted> {
    estimated_or_coarse(model, &data.first_states(), data, ALL)
        .filter(|fitted| fitted.positions(data).is_ok())
}

/// A model without what the judge withdrew; none where that is nothing.
fn without(model: &Model, withdrawn: &Withdrawn, data: &Data) -> Option<Model> {
    let mut model = model.clone();
    let (terms, free) = (model.terms.len(), model.free());
    model.terms.retain(|t| withdrawn.effects.iter().all(|id| id != t.effect.id));
    for term in model.terms.iter_mut().filter(|_| withdrawn.creep) {
        if let Some(creep) = term.effect.creep() {
            term.free[creep] = false;
            term.parameters[creep] = HARD * data.scale.speed;
        }
    }
    (model.terms.len() < terms || model.free() < free).then_some(model)
}

/// A mechanism that runs free, and what was found in it.
struct FreeRun<'a> {
    case: &'a Case<'a>,
    data: &'a Data<'a>,
    search: &'a Search<'a>,
    /// The nominal plant on the windows of the search, and on the whole recording.
    seen: Fitted,
    before: Fitted,
    /// The model with effects, likewise.
    chosen: Fitted,
    found: Fitted,
    creeps: bool,
}

impl Problem for FreeRun<'_> {
    fn case(&self) -> &Case<'_> {
        self.case
    }

    fn creeps(&self) -> bool {
        self.creeps
    }

    fn answer(&self, withdrawn: &Withdrawn) -> Result<DynamicOutcome, DiagnosisError> {
        let Some(model) = without(&self.chosen.model, withdrawn, self.data) else {
            return Ok(self.said(&self.chosen, &self.found));
        };
        let lost = || self.case.recording.lost(100.0);
        let small = self.search.fit(&model, &self.chosen.states).ok_or_else(lost)?;
        let found = whole(self.data, &small.model).ok_or_else(lost)?;
        Ok(self.said(&small, &found))
    }
}

/// What a model leaves of the recording.
struct Remains {
    /// Families of forces and tones, the strongest first.
    structures: Vec<Structure>,
    left: Left,
    floor: NoiseFloor,
}

impl FreeRun<'_> {
    /// Everything that is said of a model: `small` on the windows of the search, `found` on the whole recording.
    fn said(&self, small: &Fitted, found: &Fitted) -> DynamicOutcome {
        let (data, search, before) = (self.data, self.search, &self.before);
        let plant = &self.case.plant.plant;
        // The proof: the nominal and the chosen model, fitted and chosen without the rows that score.
        let proof_of = |f: &Fitted| fit(&f.model, &f.states, data, UNSCORED);
        let proofs = || parallel::join(|| proof_of(before), || proof_of(found));
        let small = search.complete(small);
        let ((proof_before, proof_after), remains) = parallel::join(proofs, || self.remains(&small, found));
        let Remains { structures, left, floor } = remains;
        let verdict = verdict::verdict(before, found, &left);
        let structures = match verdict {
            // What no named effect explains is located beside the nominal plant.
            Verdict::Unexplained if found.model.terms.len() > search.given => self.around(),
            _ => structures,
        };
        let covariance = self.covariance(found);
        let named = match verdict {
            Verdict::Unexplained | Verdict::Consistent => Vec::new(),
            _ => {
                let imperfect = verdict == Verdict::PartlyExplained;
                verdict::effects(search, data, [&small, found], &covariance, imperfect, plant)
            }
        };
        // What mimics an effect that is in no catalogue is not handed on.
        let after = if named.is_empty() { before } else { found };
        let covariance = if named.is_empty() { self.covariance(before) } else { covariance };
        let deviations = [0, 1, 2].map(|k| covariance.at(k, k).sqrt());
        let explained = 1.0 - found.cost(ALL) / before.cost(ALL).max(f64::MIN_POSITIVE);
        let locations = match verdict {
            Verdict::Consistent => Vec::new(),
            _ => {
                let reach = |variable: &str| verdict::reach(data, &self.case.recording.t_s, variable);
                verdict::locations(reach, &named, explained, &structures)
            }
        };
        let mut own = Predicted::by(self.case.recording, [before, after], |f| vec![self.positions(f)]);
        self.case.simulated.iter().for_each(|s| own.before[0].clone_from(&s.positions));
        let models = [&before.model, &after.model];
        let other = self.case.held_out.map(|r| Predicted::by(r, models, |model| predicted(r, model)));
        let idle = proof_after.as_ref().filter(|_| !named.is_empty()).and_then(|f| search.idle(f, data));
        let predicted = |f: &Option<Fitted>| f.as_ref().and_then(|f| f.positions(data).ok());
        let without = [
            // The user's simulation was fitted to nothing.
            self.case.simulated.map_or_else(|| predicted(&proof_before), |s| Some(s.positions.clone())),
            predicted(if named.is_empty() { &proof_before } else { &proof_after }),
        ];
        let channels: score::Channels = |recording| &recording.positions;
        let fit = score::fit(
            self.case,
            (channels, &plant.position_unit),
            &own,
            other.as_ref(),
            without,
            &data.fold,
        );
        let said = Said {
            verdict,
            unidentifiable: verdict::unidentifiable(&named),
            next_experiment: verdict::next_experiment(verdict, &named, &locations, &verdict::experiment),
            locations,
            effects: verdict::listed(named),
        };
        let of_plant = verdict::nominal(after.model.nominal, deviations, plant);
        let diagnosis = Diagnosis { plant: of_plant, ..self.case.said(said, floor, fit) };
        let plant = plant::to_file(&after.model, plant);
        let identified = Identified::SecondOrder(Box::new(after.model.clone()));
        DynamicOutcome { diagnosis, plant, own, other, idle, identified }
    }

    /// What a model leaves: as structure, above the noise, and as noise.
    fn remains(&self, small: &Fitted, found: &Fitted) -> Remains {
        let data = self.data;
        let rest = residual(found, data);
        let noise = autoregression(&rest, &data.runs);
        let repeated = repeated(self.case.recording);
        let bound = match repeated {
            Some(_) => None,
            None => floor::bound(found, (&rest, &self.positions(found)), data, &noise),
        };
        let mut structures = self.families(small);
        structures.extend(remainder::tone(&rest, data));
        let shown = structures.iter().map(|s| s.part * found.cost(ALL));
        let structure =
            shown.fold(remainder::above(found, repeated, &noise, !structures.is_empty()), f64::max);
        if structures.is_empty() {
            // A family of forces or a tone says better where the rest lives.
            structures.extend(bound.as_ref().map(|b| b.place.clone()));
        }
        // What named effects leave is no noise only because it could be one that is alike over ever more samples.
        let level = repeated.or(bound.as_ref().map(|b| b.level));
        let doubted = !structures.is_empty() || found.model.terms.len() > self.search.given;
        let above = remainder::above(found, level, &noise, doubted);
        let (value, from) = match (repeated, &bound) {
            (Some(value), _) => (value, "repeated periods"),
            (None, Some(bound)) => (bound.level, bound.from),
            (None, None) if structures.is_empty() && above == 0.0 => {
                (found.rms(ALL), "what the identified model leaves")
            }
            (None, None) => (noise.innovation, "what the residual's own past does not predict"),
        };
        let autocorrelation = noise.coefficients.first().copied().unwrap_or(0.0);
        let unit = self.case.plant.plant.position_unit.clone();
        let floor = NoiseFloor { value, unit, from: from.into(), autocorrelation };
        Remains { structures, left: Left { structure, above }, floor }
    }

    /// Where the nominal plant alone errs.
    fn around(&self) -> Vec<Structure> {
        let mut around = self.families(&self.seen);
        around.extend(remainder::tone(&residual(&self.before, self.data), self.data));
        around
    }

    /// The significant families of forces beside a model on the windows of the search.
    fn families(&self, model: &Fitted) -> Vec<Structure> {
        verdict::significant(structure(model, self.search.data, &self.search.whitening(model)))
    }

    fn covariance(&self, model: &Fitted) -> Symmetric {
        let noise = autoregression(&residual(model, self.data), &self.data.runs);
        verdict::covariance(model, self.data, &noise, 0)
    }

    fn positions(&self, model: &Fitted) -> Vec<f64> {
        model.positions(self.data).unwrap_or_default()
    }
}

/// What a model leaves of the recorded positions.
pub(super) fn residual(model: &Fitted, data: &Data) -> Vec<f64> {
    model.residual(data).unwrap_or_default()
}

/// The model, or one of its close rivals where the whole recording prefers that.
fn decided(search: &Search, data: &Data, chosen: Fitted) -> Fitted {
    let mut models = vec![chosen.model.clone()];
    models.extend(search.rivals(&chosen));
    if models.len() == 1 {
        return chosen;
    }
    let whole = |m: &Model| fit(m, &data.first_states(), data, FIT_ROWS);
    let mut fits = parallel::map(&models, whole).into_iter();
    let Some(own) = fits.next().flatten() else { return chosen };
    let better = fits
        .flatten()
        .filter(|f| gain(&own, f, CHOOSE_ROWS) > LEAST_GAIN)
        .min_by(|a, b| a.cost(CHOOSE_ROWS).total_cmp(&b.cost(CHOOSE_ROWS)));
    let windows = search.data;
    better.and_then(|f| fit(&f.model, &windows.first_states(), windows, FIT_ROWS)).unwrap_or(chosen)
}

/// Free run of another recording; what cannot be simulated stands still at the mean.
fn predicted(recording: &DynamicRecording, model: &Model) -> Vec<Vec<f64>> {
    let still = || vec![numerics::mean(&recording.positions[0]); recording.rows()];
    vec![score::free_run(model, recording).unwrap_or_else(still)]
}

/// Standard deviation of a reading from successive periods of a steady state.
pub(super) fn repeated(recording: &DynamicRecording) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for run in &recording.runs {
        let length = recording.period_of(run)?;
        for k in run.start..run.end.saturating_sub(length) {
            sum += (recording.positions[0][k + length] - recording.positions[0][k]).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| (0.5 * sum / count as f64).sqrt())
}
