//! One cell of a recording that is off by eight times its column's noise or more is listed, whatever the recording, and
//! the rest is diagnosed as without it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

use diagnosis::Options;
use fitter::faults::{self, BadRow, Screened};
use fitter::{Mirror, Recording};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use trials::draw::Trial;
use trials::plan::Assignment;
use trials::truth::Group;
use twin::encoder::{self, Encoder, Turning};
use twin::{Reading, Truth};

/// How many times its column's noise a cell is off: at least and at most, evenly in the logarithm.
const SIZES: [f64; 2] = [8.0, 800.0];
/// Recordings that are drawn where the environment does not say.
const DRAWN: u64 = 60;

/// A made recording: cells as numbers, and the noise of every cell.
struct Made {
    what: String,
    mirror: Mirror,
    columns: Vec<(&'static str, usize)>,
    cells: Vec<Vec<f64>>,
    /// Standard deviation of the noise of every cell; 0 where a wrong cell is not drawn.
    noise: Vec<Vec<f64>>,
    /// Rows of which the reference is disturbed anyway: to list them is right.
    disturbed: Vec<usize>,
}

impl Made {
    fn draw(seed: u64) -> Made {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let groups = [Group::Null, Group::Null, Group::Strong, Group::Strong, Group::Step, Group::Pair];
        match random.random_range(0..10) {
            0 => turning(random.random()),
            kind => {
                let group = groups[random.random_range(0..groups.len())];
                let assignment = Assignment {
                    group,
                    number: random.random_range(0..10_000),
                    seed: random.random(),
                    cell: None,
                };
                let trial = Trial::draw(&assignment, "made.csv".into()).expect("a trial");
                if kind < 7 { pair(&trial) } else { direct(&trial, kind == 7) }
            }
        }
    }

    /// The recording with one cell replaced.
    fn recording(&self, wrong: Option<(usize, usize, f64)>) -> Recording {
        let names: Vec<&str> = self.columns.iter().map(|c| c.0).collect();
        let mut text = names.join(",") + "\n";
        for (row, cells) in self.cells.iter().enumerate() {
            for (k, (cell, (_, digits))) in cells.iter().zip(&self.columns).enumerate() {
                let value = match wrong {
                    Some((at, column, value)) if (at, column) == (row, k) => value,
                    _ => *cell,
                };
                let comma = if k == 0 { "" } else { "," };
                write!(text, "{comma}{value:.digits$}").expect("text");
            }
            text.push('\n');
        }
        Recording::from_bytes("made.csv", text.as_bytes()).expect("a recording")
    }
}

/// Standard deviation of readings about the smooth course of what wanders by `deviation` within `memory_s`: their own, and
/// half of what it wanders from one reading to the next.
fn about_its_course(t_s: &[f64], row: usize, own: f64, deviation: f64, memory_s: f64) -> f64 {
    let step = (t_s[row.max(1)] - t_s[row.max(1) - 1]).min(10.0);
    (own * own + deviation * deviation * step / memory_s).sqrt()
}

/// That of a thermometer.
fn thermometer(t_s: &[f64], row: usize) -> f64 {
    about_its_course(t_s, row, 0.01, 0.12, 400.0)
}

/// Standard deviation of the intervals; where the clock is far more even than that, a tenth of an interval: less than a
/// whole one does no harm.
fn intervals(t_s: &[f64]) -> f64 {
    let mut gaps: Vec<f64> = t_s.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let kept = &gaps[..gaps.len() * 9 / 10];
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    (kept.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / kept.len() as f64).sqrt().max(0.1 * mean)
}

fn logged(trial: &Trial) -> Vec<(Reading, Truth)> {
    let distance = trial.distance_mm();
    twin::record_with_truth(&trial.device, &trial.protocol, trial.seed, &|x1, x2| {
        twin::calculated_angle_rad(x1, x2, distance)
    })
}

fn disturbed(log: &[(Reading, Truth)]) -> Vec<usize> {
    (0..log.len()).filter(|row| log[*row].1.outlier).collect()
}

fn described(trial: &Trial) -> String {
    let truth = &trial.truth;
    let ids: Vec<&str> = truth.effects.iter().map(|e| e.id.as_str()).collect();
    format!("{} {} {} [{}]", truth.schedule, truth.family, truth.temperature, ids.join(","))
}

fn pair(trial: &Trial) -> Made {
    let log = logged(trial);
    let t_s: Vec<f64> = log.iter().map(|(r, _)| r.t_s).collect();
    let clock = intervals(&t_s);
    let device = &trial.device;
    let (optics, drive) = (&device.autocollimator, &device.drive);
    let cross = device.second_axis.settling_arcsec.hypot(optics.cross_noise_arcsec);
    let coil = drive.settling_a.hypot(drive.noise_a);
    let columns = vec![
        ("t_s", 2),
        ("pass", 0),
        ("direction", 0),
        ("command_deg", 5),
        ("x1_mm", 7),
        ("x2_mm", 7),
        ("reference_arcsec", 3),
        ("cross_arcsec", 3),
        ("temperature_c", 3),
        ("coil_a", 5),
    ];
    let (mut cells, mut noise) = (Vec::new(), Vec::new());
    for (row, (r, truth)) in log.iter().enumerate() {
        let of_probe = truth.noise_arcsec() / device.arcsec_per_mm();
        let [pass, direction] = [f64::from(r.pass), f64::from(r.direction)];
        cells.push(vec![
            r.t_s,
            pass,
            direction,
            r.command_deg,
            r.x1_mm,
            r.x2_mm,
            r.reference_arcsec,
            r.cross_arcsec,
            r.temperature_c,
            r.coil_a,
        ]);
        let command = truth.noise_arcsec() / 3600.0;
        noise.push(vec![
            clock,
            0.0,
            0.0,
            command,
            of_probe,
            of_probe,
            truth.noise_arcsec(),
            cross,
            thermometer(&t_s, row),
            about_its_course(&t_s, row, coil, drive.creep_a, 500.0),
        ]);
    }
    let what = format!("pair {}", described(trial));
    Made { what, mirror: Mirror::paper(), columns, cells, noise, disturbed: disturbed(&log) }
}

/// The same device with a read-out of its angle in degrees, with or without the commanded angle.
fn direct(trial: &Trial, commanded: bool) -> Made {
    let log = logged(trial);
    let t_s: Vec<f64> = log.iter().map(|(r, _)| r.t_s).collect();
    let (clock, distance) = (intervals(&t_s), trial.distance_mm());
    let mut columns = vec![
        ("t_s", 2),
        ("pass", 0),
        ("direction", 0),
        ("measured", 7),
        ("reference", 7),
        ("temperature_c", 3),
    ];
    columns.extend(commanded.then_some(("command_deg", 5)));
    let (mut cells, mut noise) = (Vec::new(), Vec::new());
    for (row, (r, truth)) in log.iter().enumerate() {
        let measured = twin::calculated_angle_rad(r.x1_mm, r.x2_mm, distance).to_degrees();
        let of_angle = truth.noise_arcsec() / 3600.0;
        let mut row_cells = vec![
            r.t_s,
            f64::from(r.pass),
            f64::from(r.direction),
            measured,
            r.reference_arcsec / 3600.0,
            r.temperature_c,
        ];
        let mut row_noise = vec![clock, 0.0, 0.0, of_angle, of_angle, thermometer(&t_s, row)];
        if commanded {
            row_cells.push(r.command_deg);
            row_noise.push(of_angle);
        }
        cells.push(row_cells);
        noise.push(row_noise);
    }
    let mirror =
        Mirror::parse("mirror.toml", "[sensor]\nkind = \"direct\"\nunit = \"deg\"\n").expect("a mirror");
    let what = format!("direct {}", described(trial));
    Made { what, mirror, columns, cells, noise, disturbed: disturbed(&log) }
}

/// An encoder that turns.
fn turning(seed: u64) -> Made {
    let encoder = Encoder::from_seed(seed);
    let noise = trials::plan::FAMILIES[seed as usize % 4];
    let rows = encoder::record(&encoder, &Turning { noise: noise.1(), ..Turning::default() }, seed);
    let resolution = 360.0 / f64::from(encoder.counts) / 12_f64.sqrt();
    let of_angle = encoder.noise_deg.hypot(encoder.reference_noise_deg).hypot(resolution);
    let clock = intervals(&rows.iter().map(|r| r.t_s).collect::<Vec<f64>>());
    let columns = vec![
        ("t_s", 4),
        ("pass", 0),
        ("direction", 0),
        ("measured", 5),
        ("reference", 5),
        ("temperature_c", 3),
    ];
    let cells = (rows.iter())
        .map(|r| {
            let [pass, direction] = [f64::from(r.pass), f64::from(r.direction)];
            vec![r.t_s, pass, direction, r.measured, r.reference, r.temperature_c]
        })
        .collect();
    let noise_of = rows.iter().map(|_| vec![clock, 0.0, 0.0, of_angle, of_angle, 0.02]).collect();
    let mirror = "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 360.0\n";
    let mirror = Mirror::parse("mirror.toml", mirror).expect("a mirror");
    Made {
        what: format!("encoder {}", noise.0),
        mirror,
        columns,
        cells,
        noise: noise_of,
        disturbed: Vec::new(),
    }
}

/// What became of one draw.
struct Outcome {
    column: &'static str,
    what: String,
    /// Listed before anything was fitted.
    screened: bool,
    listed: bool,
    same: bool,
    falsely: Vec<BadRow>,
    row: usize,
}

fn screened<'a>(recording: &'a Recording, mirror: &Mirror) -> Screened<'a> {
    faults::screen(Cow::Borrowed(recording), &mirror.sensor).expect("a recording")
}

/// What a diagnosis says: verdict, effects, and the cells that it left out.
fn answer(recording: &Recording, mirror: &Mirror) -> ((String, Vec<String>), Vec<BadRow>) {
    let outcome = diagnosis::diagnose(recording, mirror, None, None, &Options::default());
    let d = outcome.expect("a diagnosis").diagnosis;
    let mut ids: Vec<String> = d.effects.iter().map(|e| e.id.clone()).collect();
    ids.sort();
    ((format!("{:?}", d.verdict), ids), d.bad_rows)
}

fn one(seed: u64, [least, most]: [f64; 2]) -> Outcome {
    let made = Made::draw(seed);
    let mut random = ChaCha8Rng::seed_from_u64(!seed);
    let row = random.random_range(0..made.cells.len());
    let choice: Vec<usize> = (0..made.columns.len()).filter(|k| made.noise[row][*k] > 0.0).collect();
    let column = choice[random.random_range(0..choice.len())];
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    let size = least * (most / least).powf(random.random());
    let wrong = made.cells[row][column] + sign * size * made.noise[row][column];
    let whole = made.recording(None);
    let mut falsely = screened(&whole, &made.mirror).bad_rows;
    falsely.retain(|bad| made.disturbed.iter().all(|row| whole.line(*row) != bad.line));
    let damaged = made.recording(Some((row, column, wrong)));
    let found = screened(&damaged, &made.mirror);
    let (name, line) = (made.columns[column].0, whole.line(row));
    // Without a command nothing tells which of measured and reference is wrong.
    let pair = ["measured", "reference"];
    let either = pair.contains(&name) && whole.command_deg.is_none();
    let is = |column: &str| column == name || (either && pair.contains(&column));
    let lists = |bad_rows: &[BadRow]| bad_rows.iter().any(|bad| bad.line == line && is(&bad.column));
    // The recording without that row, of which the rest has to be diagnosed alike.
    let others: Vec<usize> = (0..whole.rows()).filter(|k| *k != row).collect();
    let without = whole.select(&others);
    let kept: Vec<usize> = screened(&without, &made.mirror).kept.iter().map(|k| others[*k]).collect();
    let screened = lists(&found.bad_rows);
    // The same rows have the same answer; others are asked for it.
    let (listed, same) = if screened && found.kept == kept {
        (true, true)
    } else {
        let (said, bad_rows) = answer(&damaged, &made.mirror);
        (lists(&bad_rows), said == answer(&without, &made.mirror).0)
    };
    Outcome { column: name, what: made.what, screened, listed, same, falsely, row }
}

fn setting<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn one_bad_cell_is_listed_and_changes_nothing() {
    let count = setting("ARCSMITH_RECORDINGS_DRAWN", DRAWN);
    let sizes = [setting("ARCSMITH_LEAST_SIZE", SIZES[0]), setting("ARCSMITH_MOST_SIZE", SIZES[1])];
    let first: u64 = setting("ARCSMITH_SEED", 0);
    let outcomes: Vec<(u64, Outcome)> =
        (first..first + count).into_par_iter().map(|seed| (seed, one(seed, sizes))).collect();
    let mut by_column: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for (seed, outcome) in &outcomes {
        let (listed, all) = by_column.entry(outcome.column).or_default();
        (*listed, *all) = (*listed + usize::from(outcome.listed), *all + 1);
        let (column, row, what) = (outcome.column, outcome.row, &outcome.what);
        if !outcome.listed || !outcome.same {
            println!(
                "seed {seed}: {column} row {row} {what}: listed {} same {}",
                outcome.listed, outcome.same
            );
        }
        for bad in &outcome.falsely {
            println!("seed {seed}: {what}: falsely {bad:?}");
        }
    }
    let part = |of: &dyn Fn(&Outcome) -> bool| {
        outcomes.iter().filter(|(_, outcome)| of(outcome)).count() as f64 / count as f64
    };
    let [screened, listed, same, falsely] =
        [part(&|o| o.screened), part(&|o| o.listed), part(&|o| o.same), part(&|o| !o.falsely.is_empty())];
    println!(
        "{by_column:?}\nscreened {screened:.4}, listed {listed:.4}, same answer {same:.4}, falsely {falsely:.4} of {count}"
    );
    assert!(listed >= 0.95 && same >= 0.95 && falsely <= 0.05, "{listed} {same} {falsely}");
}
