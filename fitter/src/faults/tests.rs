use super::*;
use crate::recording::Readings;
use crate::table::Column;

const CALIBRATION: &str = include_str!("../../data/calibration.csv");

fn default() -> (Recording, Sensor) {
    let (recording, mirror) = crate::default_recording().unwrap();
    (recording, mirror.sensor)
}

/// The embedded recording with the cell of `column` on line 60 changed.
fn with(column: &str, change: impl Fn(f64) -> f64) -> Recording {
    let header: Vec<&str> = CALIBRATION.lines().next().unwrap().split(',').collect();
    let index = header.iter().position(|name| *name == column).unwrap();
    let line = |(k, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if k == 59 {
            cells[index] = change(cells[index].parse().unwrap()).to_string();
        }
        cells.join(",") + "\n"
    };
    let text: String = CALIBRATION.lines().enumerate().map(line).collect();
    Recording::from_bytes("calibration.csv", text.as_bytes()).unwrap()
}

fn listed(recording: &Recording) -> Vec<(u64, String)> {
    let (_, sensor) = default();
    screen(Cow::Borrowed(recording), &sensor)
        .unwrap()
        .bad_rows
        .into_iter()
        .map(|bad| (bad.line, bad.column))
        .collect()
}

#[test]
fn a_clean_recording_loses_nothing() {
    let (recording, sensor) = default();
    let screened = screen(Cow::Borrowed(&recording), &sensor).unwrap();
    assert_eq!(screened.bad_rows, []);
    assert_eq!(*screened.recording, recording);
    assert!(screened.notes.is_empty(), "{:?}", screened.notes);
}

/// A number from 0 to 1, as if drawn.
fn even(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

/// The reference stands at the same twelve places in every one of 80 passes, so that the error goes with the reading's noise.
#[test]
fn noise_at_places_that_repeat_is_no_bad_cell() {
    let mut text = String::from("t_s,pass,direction,measured,reference\n");
    for row in 0..960_u32 {
        let (pass, k) = (row / 12, row % 12);
        let place = if pass.is_multiple_of(2) { k } else { 11 - k };
        // Twelve even draws are nearly normal together.
        let noise = 1e-4 * ((0..12).map(|k| even(u64::from(12 * row + k))).sum::<f64>() - 6.0);
        let reference = 0.1 * f64::from(place);
        let direction = if pass.is_multiple_of(2) { 1 } else { -1 };
        text += &format!("{},{pass},{direction},{:.7},{reference:.7}\n", 3 * row, reference + noise);
    }
    let recording = Recording::from_bytes("repeated.csv", text.as_bytes()).unwrap();
    let mirror = crate::Mirror::parse("mirror.toml", "[sensor]\nkind = \"direct\"\nunit = \"mm\"").unwrap();
    let screened = screen(Cow::Borrowed(&recording), &mirror.sensor).unwrap();
    assert_eq!(screened.bad_rows, []);
}

/// Eight and more times the scatter of a row: probes 34 nm, autocollimator and probes 0.55 arcsec together, thermometer
/// 0.02 K, intervals 0.3 s; codes and the largest numbers as well.
#[test]
fn one_bad_cell_of_any_column_is_listed_with_its_line() {
    for (column, size) in [
        ("x1_mm", 3e-4),
        ("x2_mm", 3e-4),
        ("reference_arcsec", 5.0),
        ("cross_arcsec", 3.0),
        ("temperature_c", 0.25),
        ("coil_a", 0.012),
        ("command_deg", 0.01),
        ("t_s", 2.6),
    ] {
        for change in [size, -size, 4.0 * size] {
            let expected = vec![(60, column.to_string())];
            assert_eq!(listed(&with(column, |value| value + change)), expected, "{change}");
        }
        for value in [-9999.0, 99999.0, 1e200] {
            assert_eq!(listed(&with(column, |_| value)), [(60, column.to_string())], "{value}");
        }
    }
    assert_eq!(listed(&with("direction", |direction| -direction)), [(60, "direction".to_string())]);
}

/// Two in succession, as a logger writes them that has lost its clock.
#[test]
fn times_that_stand_for_no_time_are_listed() {
    let (mut recording, _) = default();
    recording.time_s[58..60].fill(-9999.0);
    assert_eq!(listed(&recording), [(60, "t_s".to_string()), (61, "t_s".to_string())]);
}

/// A code beside values nearly as large, in rows that follow one another.
#[test]
fn codes_beside_large_values_are_listed() {
    let (mut recording, _) = default();
    let Readings::Pair { reference_arcsec: Some(reference), .. } = &mut recording.readings else { panic!() };
    assert!(reference.iter().any(|value| value.abs() > 5000.0));
    reference[58..60].fill(-9999.0);
    let column = "reference_arcsec".to_string();
    assert_eq!(listed(&recording), [(60, column.clone()), (61, column)]);
}

/// Of two positions one may be 999.
#[test]
fn a_position_is_no_code() {
    let (mut recording, _) = default();
    let command = recording.command_deg.as_mut().unwrap();
    command.iter_mut().enumerate().for_each(|(row, value)| *value = [0.0, 999.0][row / 20 % 2]);
    assert_eq!(gross::faults(&recording), []);
}

/// A row whose readings are those of other columns, far from all others.
#[test]
fn lone_values_are_listed() {
    let (mut recording, _) = default();
    let Readings::Pair { x1_mm, x2_mm, .. } = &mut recording.readings else { panic!() };
    (x1_mm[58], x2_mm[58]) = (25.0, -31.0);
    assert_eq!(listed(&recording), [(60, "x1_mm".to_string()), (60, "x2_mm".to_string())]);
}

/// The last row of a pass: the pause after it hides where the next one would put it.
#[test]
fn a_wrong_time_beside_a_pause_is_listed() {
    let (mut recording, _) = default();
    let last = (1..recording.rows()).find(|row| recording.pass[*row] != recording.pass[row - 1]).unwrap() - 1;
    recording.time_s[last] += 2.6;
    assert_eq!(listed(&recording), [(recording.line(last), "t_s".to_string())]);
}

#[test]
fn the_other_rows_stay_as_they_were() {
    let (whole, sensor) = default();
    let screened = screen(Cow::Owned(with("x1_mm", |_| -9999.0)), &sensor).unwrap();
    let kept: Vec<usize> = (0..whole.rows()).filter(|row| *row != 58).collect();
    assert_eq!(screened.kept, kept);
    assert_eq!(screened.recording.readings, whole.select(&kept).readings);
    assert_eq!(screened.recording.line(58), 61);
}

/// Steps, drifts and bumps of a row and more that come again are physics.
#[test]
fn physics_is_not_bad() {
    let (mut recording, _) = default();
    let angles = recording.command_deg.clone().unwrap();
    let times = recording.time_s.clone();
    let Readings::Pair { reference_arcsec: Some(reference), .. } = &mut recording.readings else { panic!() };
    for (row, value) in reference.iter_mut().enumerate() {
        // A defect one step wide, a step of the mount, and a drift.
        *value += 30.0 * (-((angles[row] - 0.62) / 0.04).powi(2)).exp();
        *value += if row > 100 { 20.0 } else { 0.0 } + 0.02 * times[row];
    }
    assert_eq!(listed(&recording), []);
}

/// A few rows have much of what a column measures, and physics goes with its square.
#[test]
fn what_a_further_column_explains_is_not_bad() {
    let (mut recording, _) = default();
    let wave = |row: usize, k: usize| ((row * row * (2 * k + 1)) as f64 * 0.37 + (k * row) as f64).sin();
    let sum = |row: usize| (0..6).map(|k| wave(row, k)).sum::<f64>();
    // Longer tails than of a normal distribution.
    let values: Vec<f64> = (0..recording.rows()).map(|row| sum(row) * sum(row).abs().powf(0.3)).collect();
    let add = |recording: &mut Recording, row: usize, by: f64| {
        let Readings::Pair { reference_arcsec: Some(reference), .. } = &mut recording.readings else {
            panic!()
        };
        reference[row] += by;
    };
    values.iter().enumerate().for_each(|(row, value)| add(&mut recording, row, value * value));
    assert!(listed(&recording).len() > 1);
    recording.further.push(Column { name: "vibration_mm_s".into(), values: values.into() });
    assert_eq!(listed(&recording), []);
    // What the column does not explain is bad.
    add(&mut recording, 110, -100.0);
    assert_eq!(listed(&recording), [(112, "reference_arcsec".to_string())]);
}

#[test]
fn too_many_bad_cells_are_refused_with_the_first_of_them() {
    let (mut recording, sensor) = default();
    let Readings::Pair { x1_mm, .. } = &mut recording.readings else { panic!() };
    x1_mm.iter_mut().step_by(8).for_each(|value| *value = -9999.0);
    let message = screen(Cow::Borrowed(&recording), &sensor).unwrap_err().to_string();
    for part in ["line 2", "column `x1_mm`", "-9999", "27 of 210 rows", "at most a tenth"] {
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn findings_remove_nothing() {
    let (mut recording, sensor) = default();
    recording.time_s[100..].iter_mut().for_each(|t| *t += 4000.0);
    let Readings::Pair { x2_mm, .. } = &mut recording.readings else { panic!() };
    x2_mm[0] += 0.0;
    let screened = screen(Cow::Borrowed(&recording), &sensor).unwrap();
    assert_eq!(screened.bad_rows, []);
    assert!(screened.notes[0].contains("a pause of"), "{:?}", screened.notes);
}

/// A column that a trend of its neighbours tells to a thousandth, but at the ends, where one side alone speaks.
#[test]
fn a_smooth_course_has_no_bad_cells_at_its_ends() {
    let header: Vec<&str> = CALIBRATION.lines().next().unwrap().split(',').collect();
    let index = header.iter().position(|name| *name == "temperature_c").unwrap();
    let line = |(k, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if k > 0 {
            cells[index] = format!("{:.4}", 25.0 + 0.01 * k as f64 + 0.09 * (0.37 * k as f64).sin());
        }
        cells.join(",") + "\n"
    };
    let text: String = CALIBRATION.lines().enumerate().map(line).collect();
    let recording = Recording::from_bytes("calibration.csv", text.as_bytes()).unwrap();
    assert_eq!(listed(&recording), []);
}

/// A load that changes its level may do so right after the first row, and a column that does not is wrong there.
#[test]
fn a_column_that_jumps_may_jump_beside_its_first_row() {
    let level = |row: usize| [0.8, -0.3, 1.0, -0.4, 1.1, -0.5, 0.9][row.div_ceil(40)];
    let recorded = |jumps: f64| {
        let (mut recording, _) = default();
        let noise = |row: usize| 0.002 * ((row * row) as f64 * 0.37).sin();
        let value =
            |row: usize| if row == 0 { 0.8 } else { jumps * level(row) - 0.3 * (1.0 - jumps) + noise(row) };
        let values: Vec<f64> = (0..recording.rows()).map(value).collect();
        recording.further.push(Column { name: "load_n".into(), values: values.into() });
        listed(&recording)
    };
    assert_eq!(recorded(1.0), []);
    assert_eq!(recorded(0.0), [(2, "load_n".to_string())]);
}

#[test]
fn a_row_that_is_there_twice_counts_once() {
    let (whole, sensor) = default();
    let mut lines: Vec<&str> = CALIBRATION.lines().collect();
    lines.insert(41, lines[20]);
    lines.insert(42, lines[40]);
    let recording = Recording::from_bytes("calibration.csv", (lines.join("\n") + "\n").as_bytes()).unwrap();
    let screened = screen(Cow::Borrowed(&recording), &sensor).unwrap();
    let told: Vec<(u64, &str)> =
        screened.bad_rows.iter().map(|bad| (bad.line, bad.reason.as_str())).collect();
    assert_eq!(
        told,
        [(42, "the row repeats line 21 in every column"), (43, "the row repeats line 41 in every column")]
    );
    assert_eq!(screened.recording.time_s, whole.time_s);
}
