//! The unit of work: one recording in, the rows of one unit out. It depends on nothing else, so that any engine may run it.

use diagnosis::fleet::{Estimate, Forced};
use diagnosis::{Options, Outcome};
use fitter::figures::NORMAL_95;
use fitter::recording::{Mapping, Purpose, Reading};
use fitter::{Mirror, Recording, RecordingError};

/// What every unit of a fleet is diagnosed with.
pub struct Asked {
    /// The nominal mirror.
    pub mirror: Mirror,
    /// Columns under other names.
    pub mappings: Vec<Mapping>,
    /// What a diagnosis is asked for.
    pub options: Options,
}

/// What is known of a unit before its recording is read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: String,
    /// Name of the file that holds it.
    pub file: String,
    /// Its lot.
    pub lot: Option<String>,
    /// Its time, in whatever unit the user counts.
    pub time: Option<f64>,
}

/// What is said of a unit.
pub struct Answer {
    /// Which.
    pub unit: Unit,
    /// SHA-256 of its recording, where that could be read.
    pub sha256: Option<String>,
    /// What was found, or why nothing could be.
    pub found: Result<Found, String>,
}

/// A diagnosis as it stands in the tables.
pub struct Found {
    /// Number of readings.
    pub rows: usize,
    /// The answer.
    pub diagnosis: diagnosis::Diagnosis,
    /// What the recording says of every effect.
    pub forced: Forced,
    /// The coefficients file, where one is handed on.
    pub coefficients: Option<String>,
}

/// A parameter of an effect in one unit.
pub struct Estimated {
    /// Of an effect that the unit's diagnosis names; else forced.
    pub named: bool,
    /// Id of the effect.
    pub effect: String,
    /// Its parameter.
    pub parameter: String,
    /// The shape at which it was forced; blank where nothing was chosen.
    pub at: String,
    /// Unit of what follows.
    pub unit_of_measure: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Its standard error; of a named effect as the interval has it.
    pub error: f64,
}

impl Asked {
    /// How a recording is read.
    pub fn reading(&self) -> Reading<'_> {
        Reading { purpose: Purpose::Fit, mappings: &self.mappings, sensor: Some(&self.mirror.sensor) }
    }

    /// Diagnoses one unit. What cannot be diagnosed is an answer too.
    pub fn answer(&self, unit: Unit, recording: Result<Recording, RecordingError>) -> Answer {
        let recording = match recording {
            Ok(recording) => recording,
            Err(error) => return Answer { unit, sha256: None, found: Err(error.to_string()) },
        };
        let found = diagnosis::diagnose(&recording, &self.mirror, None, None, &self.options);
        let found =
            found.map(|outcome| Found::of(recording.rows(), outcome)).map_err(|error| error.to_string());
        Answer { unit, sha256: Some(recording.sha256), found }
    }
}

impl Found {
    fn of(rows: usize, outcome: Outcome) -> Found {
        let Outcome { diagnosis, coefficients, forced, .. } = outcome;
        let coefficients = coefficients.map(|file| file.to_sealed_json());
        Found { rows, diagnosis, forced: forced.unwrap_or_default(), coefficients }
    }

    /// The parameters of the effects that are named, as their intervals have them, and of all that are forced.
    pub fn estimated(&self) -> Vec<Estimated> {
        let named = self.diagnosis.effects.iter().flat_map(|effect| {
            effect.parameters.iter().map(|p| Estimated {
                named: true,
                effect: effect.id.clone(),
                parameter: p.name.clone(),
                at: String::new(),
                unit_of_measure: p.unit.clone(),
                value: p.value,
                ci95: p.ci95,
                error: (p.ci95[1] - p.ci95[0]) / (2.0 * NORMAL_95),
            })
        });
        let forced = self.forced.tests.iter().zip(self.forced.alone()).filter_map(|(test, estimate)| {
            let Estimate { value, error } = estimate?;
            Some(Estimated {
                named: false,
                effect: test.effect.clone(),
                parameter: test.parameter.clone(),
                at: test.at.clone(),
                unit_of_measure: test.unit.clone(),
                value,
                ci95: [value - NORMAL_95 * error, value + NORMAL_95 * error],
                error,
            })
        });
        named.chain(forced).collect()
    }
}
