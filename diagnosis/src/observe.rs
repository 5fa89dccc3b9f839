//! From a recording and the nominal mirror to the rows of a diagnosis: calculated angle, angular error, the
//! observables that can be used, and a sentence for every one that cannot.

use fitter::error_model::Sensor;
use fitter::recording::{Note, Readings};
use fitter::turn::Turn;
use fitter::{Mirror, Recording};
use numerics::{mean, range};

use crate::content::is_noise_alone;
use crate::error::DiagnosisError;
use crate::rows::{Column, Rows, pauses};
use crate::slow_channel::without_noise;
use crate::thresholds::observe::FEWEST_ROWS;

/// The user's own simulation of the same rows.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// The predicted reference, in the recording's unit.
    pub reference: Vec<f64>,
}

/// The base as the user wants it; chosen by cross-validation where nothing is said.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
    /// Order of the polynomial.
    pub order: Option<usize>,
    /// Number of harmonics of a whole turn.
    pub turn_harmonics: Option<usize>,
}

/// Prepares a recording for diagnosis.
///
/// # Errors
/// See [`DiagnosisError`].
pub fn observe(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&Simulated>,
    wanted: Wanted,
) -> Result<Rows, DiagnosisError> {
    let truth = reference(recording, mirror, simulated)?;
    let n = recording.rows();
    let sensor = &mirror.sensor;
    let per = sensor.per_internal();
    let (reading, truth, turn) = match unwound(recording, mirror, simulated, wanted)? {
        Some(Unwound { reading, truth, turn }) => (reading, truth, turn),
        None => ((0..n).map(|i| recording.reading(i)).collect(), truth, None),
    };
    let weight: Vec<f64> = reading.iter().map(|r| sensor.gain(*r)).collect();
    let theta: Vec<f64> = reading.iter().map(|r| per * sensor.calculated(*r)).collect();
    let expected = simulated.map_or(theta.as_slice(), |s| s.reference.as_slice());
    let error: Vec<f64> = expected.iter().zip(&truth).map(|(e, t)| e - t).collect();
    let mut not_testable = Vec::new();
    let mut usable = |name: &str, values: &[f64]| match unusable(values) {
        None => Some(values.to_vec()),
        Some(reason) => {
            not_testable.push(format!("{name}: {reason}"));
            None
        }
    };
    let mut take = |name: &str| recording.column(name).and_then(|values| usable(name, values));
    let cross_arcsec = take("cross_arcsec");
    let temperature_c = take("temperature_c");
    let coil_a = take("coil_a");
    let common_mode_um = match &recording.readings {
        Readings::Pair { x1_mm, x2_mm, .. } => {
            let values: Vec<f64> = x1_mm.iter().zip(x2_mm).map(|(a, b)| 500.0 * (a + b)).collect();
            usable("common mode of x1_mm and x2_mm", &values)
        }
        Readings::Direct { .. } => None,
    };
    let known = ["cross_arcsec", "temperature_c", "coil_a"];
    let extra: Vec<Column> = recording
        .further
        .iter()
        .filter(|c| !known.contains(&c.name.as_str()))
        .filter_map(|c| usable(&c.name, &c.values).map(|values| Column { name: c.name.clone(), values }))
        .collect();
    let mut rows = Rows {
        means: false,
        unit: sensor.error_unit().to_string(),
        pair: matches!(sensor, Sensor::EddyCurrentPair { .. }),
        t_s: recording.time_s.to_vec(),
        pauses_s: pauses(&recording.time_s),
        pass: recording.pass.iter().map(|p| i64::from(*p)).collect(),
        direction: recording.direction.iter().map(|d| f64::from(*d)).collect(),
        reading,
        weight,
        theta,
        truth,
        error,
        common_mode_um,
        cross_arcsec,
        temperature_c,
        coil_a,
        command_deg: (recording.command_deg.as_deref())
            .filter(|c| c.iter().all(|v| v.is_finite()))
            .map(<[f64]>::to_vec),
        extra,
        further_columns: 0,
        order: match (&turn, wanted) {
            // `fit` chooses the harmonics by cross-validation, or has them given.
            (Some(turn), _) if turn.whole => Some(2 * turn.amplitudes.len()),
            (_, Wanted { order, .. }) => order,
        },
        turn,
        not_testable,
    };
    note_limits(recording, &mut rows);
    Ok(rows)
}

/// The reference of a recording that can be diagnosed.
fn reference(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&Simulated>,
) -> Result<Vec<f64>, DiagnosisError> {
    const PAIR: &str = "an eddy-current pair (x1_mm, x2_mm)";
    const DIRECT: &str = "a sensor that reports the angle or position itself (measured)";
    let (file, rows) = (recording.file.clone(), recording.rows());
    let pair = matches!(mirror.sensor, Sensor::EddyCurrentPair { .. });
    let (reference, found, expected) = match &recording.readings {
        Readings::Pair { reference_arcsec, .. } => (reference_arcsec, PAIR, "reference_arcsec"),
        Readings::Direct { reference, .. } => (reference, DIRECT, "reference"),
    };
    if pair != (found == PAIR) {
        return Err(DiagnosisError::Kind { file, found, expected: if pair { PAIR } else { DIRECT } });
    }
    let Some(truth) = reference.as_deref().map(<[f64]>::to_vec) else {
        return Err(DiagnosisError::NoReference { file, expected });
    };
    if rows < FEWEST_ROWS {
        return Err(DiagnosisError::TooShort { file, rows, needed: FEWEST_ROWS });
    }
    fitter::check(recording, mirror)?;
    match simulated.map(|simulated| simulated.reference.len()).filter(|simulated| *simulated != rows) {
        None => Ok(truth),
        Some(simulated) => Err(DiagnosisError::Rows {
            file,
            found: format!("{simulated} simulated rows"),
            expected: format!("{rows}"),
        }),
    }
}

/// Why nothing that depends on a column can be tested; none where it can.
fn unusable(values: &[f64]) -> Option<String> {
    let blanks = values.iter().filter(|v| !v.is_finite()).count();
    if blanks > 0 {
        let rows = values.len();
        return Some(format!("{blanks} of {rows} rows are blank; nothing that depends on it can be tested"));
    }
    let (low, high) = range(values);
    if low == 0.0 && high == 0.0 {
        return Some(
            "all zero, as if nothing were connected; nothing that depends on it can be tested".into(),
        );
    }
    (high - low <= 1e-12 * high.abs().max(low.abs()))
        .then(|| format!("constant at {low}; a dependence on it cannot be told from an offset"))
}

/// What the rows as they are cannot show, and the slow channels without their own noise.
fn note_limits(recording: &Recording, rows: &mut Rows) {
    if rows.temperature_c.as_ref().is_some_and(|t| is_noise_alone(t, &rows.scaled_reading())) {
        rows.temperature_c = None;
        rows.not_testable.push(
            "temperature_c: noise alone, nothing slow and nothing that goes with the angle; nothing that depends \
             on it can be tested"
                .into(),
        );
    }
    note_columns(recording, rows);
    note_time(recording, rows);
    for readings in [&mut rows.temperature_c, &mut rows.common_mode_um].into_iter().flatten() {
        *readings = without_noise(&rows.t_s, readings);
    }
    if rows.single_move() {
        rows.not_testable.push(
            "one move only: time runs with the angle, so that drift, warm-up and steps cannot be told from the \
             error's own shape"
                .into(),
        );
    }
    if !rows.both_directions() {
        rows.not_testable.push(
            "passes of one direction only: backlash, hysteresis, lag and gain cannot be told apart".into(),
        );
    }
}

/// Readings and references that go on beyond a turn.
struct Unwound {
    reading: Vec<f64>,
    truth: Vec<f64>,
    turn: Option<Turn>,
}

/// Readings and references of a sensor that turns, each on the turn where it belongs: a reading that passes the end
/// of the turn goes on, as the axis does. None of another sensor, and none beside the user's own simulation, which
/// predicts the reference as it was recorded.
fn unwound(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&Simulated>,
    wanted: Wanted,
) -> Result<Option<Unwound>, DiagnosisError> {
    let Sensor::Direct { revolution: Some(turn), .. } = mirror.sensor else {
        return match wanted.turn_harmonics {
            Some(_) => Err(DiagnosisError::NoTurn { file: recording.file.clone() }),
            None => Ok(None),
        };
    };
    if simulated.is_some() {
        return Ok(None);
    }
    let options = fitter::Options {
        order: wanted.order,
        harmonics: wanted.turn_harmonics,
        ..fitter::Options::default()
    };
    let fit = fitter::fit(recording, mirror, &options)?;
    let whole = fit.coefficients.whole_turn();
    // The fit's readings lie within one turn, its errors on the turn of their reading. Over a whole turn a reading that
    // passes the end goes on.
    let mut reading = fit.calibrated.reading;
    let mut before = recording.reading(0);
    for reading in reading.iter_mut().filter(|_| whole) {
        *reading -= turn * ((*reading - before) / turn).round();
        before = *reading;
    }
    let truth = reading.iter().zip(&fit.calibrated.error).map(|(reading, error)| reading - error).collect();
    Ok(Some(Unwound { reading, truth, turn: fit.coefficients.turn }))
}

/// Columns that were left out or assumed when the file was read.
fn note_columns(recording: &Recording, rows: &mut Rows) {
    for note in &recording.notes {
        match note {
            Note::TextColumn { column } => rows
                .not_testable
                .push(format!("{column}: holds no numbers; nothing that depends on it can be tested")),
            Note::Assumed { column, taken } => rows.not_testable.push(format!("{column}: missing, {taken}")),
            Note::EmptyPass { .. } => rows.not_testable.push(note.to_string()),
            // How a file was read costs no observable.
            Note::TimeBackward { .. } | Note::Timestamps { .. } | Note::Dialect(_) | Note::Mapped { .. } => {}
        }
    }
}

/// What time itself forbids or limits. Time that runs backward is replaced by the row number.
fn note_time(recording: &Recording, rows: &mut Rows) {
    let backward = recording.notes.iter().any(|n| matches!(n, Note::TimeBackward { .. }))
        || rows.t_s.windows(2).any(|w| w[1] < w[0]);
    if backward {
        rows.not_testable.push(
            "t_s: time runs backward; the order of the rows stands for it, and rates and time constants are \
             per row, not per second"
                .into(),
        );
        rows.t_s = (0..rows.len()).map(|i| i as f64).collect();
        return;
    }
    let gaps: Vec<f64> = rows.t_s.windows(2).map(|w| w[1] - w[0]).collect();
    let (_, longest) = range(&gaps);
    if longest > 20.0 * mean(&gaps) && longest > 0.05 * rows.duration_s() {
        rows.not_testable.push(format!(
            "t_s: a gap of {longest:.0} s without readings; what happened in it (a step, a drift, a warm-up) \
             cannot be told apart"
        ));
    }
}
