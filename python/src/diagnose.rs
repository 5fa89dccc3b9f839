//! `diagnose` in Python: of calibrations with a mirror, of motion with a plant.

use std::path::{Path, PathBuf};

use arcsmith::shared::{declared, diagnosis_summary, motion};
use diagnosis::dynamic::{self, Case, DynamicOutcome, DynamicRecording, OwnSimulation};
use diagnosis::observe::Wanted;
use pages::Beside;
use diagnosis::simulated::{self, Simulation};
use diagnosis::{Options, Outcome, report};
use fitter::message::Message;
use fitter::plant::PlantFile;
use fitter::recording::{Mapping, Note, Purpose, Reading};
use fitter::{Mirror, text_safety};
use pyo3::prelude::*;
use serde_json::json;

use crate::coefficients::{Coefficients, mirror as nominal_mirror, plant as nominal_plant, shown};
use crate::columns::Columns;
use crate::error::{detached, refused};
use crate::python;
use crate::simulate::numbered;
use crate::table::{Given, mappings, warn_of_times};

/// What a recording says of its simulation: where it differs, what explains it, and whether the fit improves. `print` shows
/// what the program prints.
#[pyclass(frozen, module = "arcsmith")]
pub struct Diagnosis {
    found: Found,
    /// What was noticed while the recording was read.
    notes: Vec<Note>,
}

enum Found {
    OfCalibration(Box<Outcome>),
    OfMotion(Box<DynamicRecording>, Box<DynamicOutcome>),
}

impl Diagnosis {
    fn answer(&self) -> &diagnosis::Diagnosis {
        match &self.found {
            Found::OfCalibration(outcome) => &outcome.diagnosis,
            Found::OfMotion(_, outcome) => &outcome.diagnosis,
        }
    }

    /// The coefficients that are handed on.
    pub fn file(&self) -> Option<&fitter::Coefficients> {
        match &self.found {
            Found::OfCalibration(outcome) => outcome.coefficients.as_ref(),
            Found::OfMotion(..) => None,
        }
    }
}

#[pymethods]
impl Diagnosis {
    /// "consistent", "explained", "described", "partly_explained" or "unexplained".
    #[getter]
    fn verdict(&self) -> String {
        json!(self.answer().verdict).as_str().unwrap_or_default().to_string()
    }

    /// The ids of the effects that were named, the strongest first.
    #[getter]
    fn effects(&self) -> Vec<String> {
        self.answer().effects.iter().map(|effect| effect.id.clone()).collect()
    }

    /// Sentences about how the recording was read.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.iter().map(ToString::to_string).collect()
    }

    /// The augmented model of a calibration, for `apply` and `generate`; None where it is withheld, and of motion.
    #[getter]
    fn coefficients(&self) -> Option<Coefficients> {
        self.file().cloned().map(Coefficients)
    }

    /// The augmented plant of a motion: the text of a plant.toml, which `simulate` takes; None of a calibration.
    #[getter]
    fn plant(&self) -> Option<String> {
        match &self.found {
            Found::OfCalibration(_) => None,
            Found::OfMotion(_, outcome) => Some(outcome.plant.to_toml()),
        }
    }

    /// What is predicted of a motion, row for row: `t_s` (s), `before`, `after` in position units, under feedback in drive
    /// units; None of a calibration.
    #[getter]
    fn simulated(&self) -> Option<Columns> {
        let Found::OfMotion(_, outcome) = &self.found else { return None };
        let predicted = outcome.other.as_ref().unwrap_or(&outcome.own);
        let mut columns = vec![("t_s".to_string(), predicted.t_s.to_vec())];
        columns.extend(numbered("before", predicted.before.iter().cloned()));
        columns.extend(numbered("after", predicted.after.iter().cloned()));
        let said = json!({"rows": predicted.t_s.len()}).to_string();
        Some(Columns::new(columns, Vec::new(), said))
    }

    /// The answer, as `arcsmith diagnose` writes it: see the page "File formats".
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::from_json(py, &self.to_json())
    }

    /// The text of the answer's file, as the program writes it.
    fn to_json(&self) -> String {
        serde_json::to_string_pretty(self.answer()).unwrap_or_default() + "\n"
    }

    /// The report: one self-contained page (HTML).
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            Ok(match &self.found {
                Found::OfCalibration(outcome) => report::page(outcome, &Beside::default()),
                Found::OfMotion(recording, outcome) => {
                    report::of_motion(recording, outcome, &Beside::default())
                }
            })
        })
    }

    /// The figures of the report (SVG), by title; a notebook shows them.
    fn plot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::figures(py, &self.report(py)?)
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        python::framed(py, &self.report(py)?)
    }

    fn __str__(&self) -> String {
        diagnosis_summary::plain_text(self.answer()).trim_end().to_string()
    }

    fn __repr__(&self) -> String {
        format!("<arcsmith.Diagnosis {}>", diagnosis_summary::sentence(self.answer()))
    }
}

/// What a diagnosis is asked for beside recording and device.
struct Asked {
    given: Given,
    held_out: Option<Given>,
    simulated: Option<Given>,
    mappings: Vec<Mapping>,
    effects: Option<PathBuf>,
    without: Vec<String>,
    harmonics: Option<usize>,
    base: Wanted,
}

/// Locates where a recording differs from its simulation, names the physics, and shows on held-out data that the fit
/// improves.
///
/// `recording`, `mirror`, `map` and `name` are as for `fit`. With `plant` (the path of plant.toml, or a dict of its sections)
/// in place of `mirror` it is a motion: `t_s` (s), `drive`, `position` in the plant's units.
///
/// `effects`: path of a TOML file of your own effects. `held_out`: another recording of the same device. `simulated`: your own
/// simulation of the same rows, `t_s` and the predicted `reference_arcsec`, `reference` or `position`. `without`: ids of
/// effects that are left out. `order`, `turn_harmonics`: of the base, instead of being chosen. `harmonics`: at most so many
/// of a periodic error are handed on.
///
/// Raises ArcsmithError.
#[pyfunction]
#[pyo3(signature = (
    recording, mirror=None, *, plant=None, map=None, effects=None, held_out=None, simulated=None, without=None,
    harmonics=None, order=None, turn_harmonics=None, name=None
))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn diagnose(
    py: Python<'_>,
    recording: &Bound<'_, PyAny>,
    mirror: Option<&Bound<'_, PyAny>>,
    plant: Option<&Bound<'_, PyAny>>,
    map: Option<&Bound<'_, PyAny>>,
    effects: Option<PathBuf>,
    held_out: Option<&Bound<'_, PyAny>>,
    simulated: Option<&Bound<'_, PyAny>>,
    without: Option<Vec<String>>,
    harmonics: Option<usize>,
    order: Option<usize>,
    turn_harmonics: Option<usize>,
    name: Option<&str>,
) -> PyResult<Diagnosis> {
    let other = |object: Option<&Bound<'_, PyAny>>, name| {
        object.map(|object| Given::of(object, Some(name))).transpose()
    };
    let asked = Asked {
        given: Given::of(recording, name)?,
        held_out: other(held_out, "held-out table")?,
        simulated: other(simulated, "simulation table")?,
        mappings: mappings(map)?,
        effects,
        without: without.unwrap_or_default(),
        harmonics,
        base: Wanted { order, turn_harmonics },
    };
    let diagnosis = match (mirror, plant) {
        (Some(mirror), None) => {
            let (mirror, word) = nominal_mirror(mirror)?;
            detached(py, || of_calibration(asked, &mirror, &word))?
        }
        (None, Some(plant)) => {
            let (plant, word) = nominal_plant(plant)?;
            detached(py, || of_motion(asked, &plant, &word))?
        }
        _ => {
            let what = Message::of("a diagnosis needs `mirror` or `plant`, one of the two");
            return Err(refused(
                py,
                &what.mend("give the mirror of a calibration, or the plant of a motion"),
            ));
        }
    };
    warn_of_times(py, &diagnosis.notes)?;
    Ok(diagnosis)
}

fn of_calibration(asked: Asked, mirror: &Mirror, word: &str) -> Result<Diagnosis, Message> {
    if asked.base.order.is_some() && asked.base.turn_harmonics.is_some() {
        return Err(
            Message::of("`order` and `turn_harmonics` exclude each other").mend("give one of the two")
        );
    }
    let command = command(&asked, word);
    let declared = declared(&mirror.sensor, asked.effects.as_deref(), &asked.without)?;
    let reading = Reading { purpose: Purpose::Fit, mappings: &asked.mappings, sensor: Some(&mirror.sensor) };
    let held_out = asked.held_out.map(|given| given.recording(&reading)).transpose()?;
    let simulated = asked.simulated.map(simulation).transpose()?;
    let recording = asked.given.recording(&reading)?;
    let simulated = simulated.map(|(_, simulation)| simulation.for_recording(&recording)).transpose()?;
    let options =
        Options { skip: asked.without, declared, base: asked.base, harmonics: asked.harmonics, command, ..Options::default() };
    let outcome = diagnosis::diagnose(&recording, mirror, simulated.as_ref(), held_out.as_ref(), &options)?;
    Ok(Diagnosis { found: Found::OfCalibration(Box::new(outcome)), notes: recording.notes })
}

fn of_motion(asked: Asked, plant: &PlantFile, word: &str) -> Result<Diagnosis, Message> {
    if asked.harmonics.is_some() || asked.base.order.is_some() || asked.base.turn_harmonics.is_some() {
        let what = "`harmonics`, `order` and `turn_harmonics` belong to a calibration";
        return Err(Message::of(what).mend("leave them out"));
    }
    let options = motion::options(Path::new(word), plant, asked.effects.as_deref(), &asked.without)?;
    let reading = motion::reading(plant, &asked.mappings);
    let read = |given: Given| match given {
        Given::File(path) => DynamicRecording::read(&path, &reading),
        Given::Table(table) => DynamicRecording::of_columns(&table.name, table.columns, &reading),
    };
    let converted = asked.given.converted();
    let recording = read(asked.given)?;
    let held_out = asked.held_out.map(read).transpose()?;
    let own = |given| -> Result<OwnSimulation, Message> {
        let (file, simulation) = simulation(given)?;
        Ok(OwnSimulation { file, positions: simulation.positions_for(&recording.t_s)? })
    };
    let simulated = asked.simulated.map(own).transpose()?;
    let outcome = dynamic::diagnose(&Case {
        recording: &recording,
        plant,
        plant_file: &shown(word),
        simulated: simulated.as_ref(),
        held_out: held_out.as_ref(),
        options: &options,
    })?;
    let notes = [&recording.notes[..], &converted].concat();
    Ok(Diagnosis { found: Found::OfMotion(Box::new(recording), Box::new(outcome)), notes })
}

/// The user's own simulation, and the name of its file.
fn simulation(given: Given) -> Result<(String, Simulation), Message> {
    let file = given.file_name();
    let read = match given {
        Given::File(path) => simulated::read(&path),
        Given::Table(table) => simulated::of_columns(&table.name, table.columns),
    };
    Ok((file, read?))
}

/// The command as it stands in the coefficients file, that of the program.
fn command(asked: &Asked, mirror: &str) -> String {
    let recording = asked.given.file_name();
    let mirror = text_safety::file_name(mirror.as_ref());
    let map: String = asked.mappings.iter().map(|mapping| format!(" --map '{mapping}'")).collect();
    let option =
        |name: &str, value: Option<usize>| value.map_or_else(String::new, |n| format!(" --{name} {n}"));
    let order = option("order", asked.base.order);
    let turn = option("turn-harmonics", asked.base.turn_harmonics);
    let harmonics = option("harmonics", asked.harmonics);
    text_safety::command(&format!("diagnose {recording} --mirror {mirror}{map}{order}{turn}{harmonics}"))
}
