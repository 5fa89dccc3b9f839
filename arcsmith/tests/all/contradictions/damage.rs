//! The kinds of damage: small functions over a recording, by name. One more is one line of a table.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::contradictions::made::{Table, normal};

/// What a kind of damage does: gives the rows whose cells must be listed as none that can be readings.
type Act = Box<dyn Fn(&mut Table, &mut ChaCha8Rng) -> Vec<usize>>;

/// A kind of damage.
pub struct Damage {
    pub name: String,
    pub act: Act,
    /// Whether the recording may be refused for it: a needed cell is missing, or too few readings or places are left.
    pub may_be_refused: bool,
}

/// What happens to single cells: a name, what is written, whether it must be listed, and whether the file may be refused.
type OfCell = (&'static str, fn(f64, f64) -> String, bool, bool);

/// Given the value and the noise of its column.
const OF_CELLS: [OfCell; 15] = [
    ("-9999", |_, _| "-9999".into(), true, false),
    ("99999", |_, _| "99999".into(), true, false),
    ("1e200", |_, _| "1e200".into(), true, false),
    ("32767", |_, _| "32767".into(), false, false),
    ("zero", |_, _| "0".into(), false, false),
    ("sign", |v, _| (-v).to_string(), false, false),
    ("a thousand times", |v, _| (1e3 * v).to_string(), false, false),
    ("a thousandth", |v, _| (1e-3 * v).to_string(), false, false),
    ("a digit slipped", |v, _| (10.0 * v).to_string(), false, false),
    ("8 sigma", |v, noise| (v + 8.0 * noise).to_string(), false, false),
    ("30 sigma", |v, noise| (v - 30.0 * noise).to_string(), false, false),
    ("1000 sigma", |v, noise| (v + 1e3 * noise).to_string(), false, false),
    ("empty", |_, _| String::new(), false, true),
    ("NaN", |_, _| "NaN".into(), false, true),
    ("text", |_, _| "error".into(), false, true),
];

/// The columns of cells, whatever the sensor: the first and the second of its readings.
const OF_COLUMNS: [&str; 4] = ["t_s", "measured", "reference", "temperature_c"];

/// What happens to whole columns and to rows, and whether the file may be refused for it.
type OfRows = (&'static str, bool, fn(&mut Table, &mut ChaCha8Rng));

const OF_ROWS: [OfRows; 45] = [
    ("nothing", false, |_, _| {}),
    ("a row twice", false, |t, r| repeat(t, r, 1)),
    ("five rows twice", false, |t, r| repeat(t, r, 5)),
    ("a row missing", false, |t, r| drop(lose(t, r, 1))),
    ("a tenth of the rows missing", false, |t, r| {
        let part = t.rows.len() / 10;
        lose(t, r, part);
    }),
    ("rows missing here and there", false, |t, _| {
        let mut row = 0;
        t.rows.retain(|_| {
            row += 1;
            row % 9 != 0 || row < 20
        });
    }),
    ("a pause of an hour", false, |t, r| shift_time(t, r, 3600.0)),
    ("a pause of twenty years", true, |t, r| shift_time(t, r, 6.3e8)),
    ("time goes back", false, |t, r| shift_time(t, r, -20.0)),
    ("time begins again", false, |t, _| {
        let half = t.rows.len() / 2;
        t.change("t_s", |row, v| if row >= half { v - half as f64 } else { v });
    }),
    ("time in milliseconds", false, |t, _| t.change("t_s", |_, v| 1e3 * v)),
    ("time stands", false, |t, _| t.change("t_s", |_, _| 7.0)),
    ("time of the year 2026", false, |t, _| t.change("t_s", |_, v| v + 1.79e9)),
    ("time jitters", false, |t, r| {
        let jitter: Vec<f64> = t.rows.iter().map(|_| 0.3 * normal(r)).collect();
        t.change("t_s", |row, v| v + jitter[row]);
    }),
    ("two rows have changed places", false, |t, r| {
        let row = r.random_range(1..t.rows.len());
        t.rows.swap(row - 1, row);
    }),
    ("two far rows have changed places", false, |t, _| {
        let last = t.rows.len() - 1;
        t.rows.swap(2, last - 2);
    }),
    ("all rows in reverse", false, |t, _| t.rows.reverse()),
    ("two columns of a row swapped", false, |t, r| {
        let row = r.random_range(0..t.rows.len());
        let (a, b) = (t.index("temperature_c"), t.index("t_s"));
        t.rows[row].swap(a, b);
    }),
    ("readings of a row swapped", false, |t, r| {
        let row = r.random_range(0..t.rows.len());
        t.rows[row].swap(3, 4);
    }),
    ("measured cut off above", false, |t, _| cut(t, 3, 0.97)),
    ("measured cut off below", false, |t, _| cut(t, 3, 0.03)),
    ("reference cut off above", false, |t, _| cut(t, 4, 0.97)),
    ("measured coarse", false, |t, _| round(t, 3, 0.01)),
    ("reference coarse", false, |t, _| round(t, 4, 0.01)),
    ("both coarse", false, |t, _| {
        round(t, 3, 0.002);
        round(t, 4, 0.002);
    }),
    ("temperature coarse", false, |t, _| t.change("temperature_c", |_, v| v.round())),
    ("temperature constant", false, |t, _| t.change("temperature_c", |_, _| 25.0)),
    ("temperature empty", false, |t, _| {
        let index = t.index("temperature_c");
        t.rows.iter_mut().for_each(|row| row[index].clear());
    }),
    ("temperature half empty", false, |t, _| {
        let index = t.index("temperature_c");
        t.rows.iter_mut().step_by(2).for_each(|row| row[index].clear());
    }),
    ("temperature in millikelvin", false, |t, _| t.change("temperature_c", |_, v| 1e3 * (v + 273.15))),
    ("temperature beyond measure", false, |t, _| t.change("temperature_c", |_, v| 1e9 * v)),
    ("temperature stuck", false, |t, _| {
        let (index, half) = (t.index("temperature_c"), t.rows.len() / 2);
        let value = t.rows[half][index].clone();
        t.rows[half..].iter_mut().for_each(|row| row[index].clone_from(&value));
    }),
    ("measured stuck for eight rows", true, |t, r| {
        let from = r.random_range(0..t.rows.len() - 8);
        let value = t.rows[from][3].clone();
        t.rows[from..from + 8].iter_mut().for_each(|row| row[3].clone_from(&value));
    }),
    ("a step of the reference", false, |t, r| {
        let (from, step) = (r.random_range(0..t.rows.len()), 50.0 * t.noise);
        t.change(t.header[t.header.len() - 2], |row, v| if row >= from { v + step } else { v });
    }),
    ("one direction", false, |t, _| t.rows.retain(|row| row[2] == "1")),
    ("all rows forward", false, |t, _| t.change("direction", |_, _| 1.0)),
    ("direction reversed", false, |t, _| t.change("direction", |_, v| -v)),
    ("direction of a row", false, |t, r| {
        let row = r.random_range(0..t.rows.len());
        t.set(row, "direction", -t.get(row, "direction"));
    }),
    ("pass of a row", false, |t, r| {
        let row = r.random_range(0..t.rows.len());
        t.rows[row][1] = t.rows[0][1].clone();
    }),
    ("a pass of a row that is far from all others", false, |t, r| {
        let row = r.random_range(0..t.rows.len());
        t.set(row, "pass", 77.0);
    }),
    ("one pass for all", false, |t, _| t.change("pass", |_, _| 1.0)),
    ("every row its pass", false, |t, _| t.change("pass", |row, _| row as f64)),
    ("a short range", true, |t, _| {
        let middle = t.rows.len() / 2;
        t.rows = t.rows[middle.saturating_sub(12)..(middle + 12).min(t.rows.len())].to_vec();
    }),
    ("few rows", true, |t, _| t.rows.truncate(10)),
    ("a pass twice", false, |t, _| {
        let (last, count) = (t.rows[t.rows.len() - 1][1].clone(), t.rows.len() as f64);
        let again: Vec<Vec<String>> = t.rows.iter().filter(|row| row[1] == last).cloned().collect();
        let first = t.rows.len();
        t.rows.extend(again);
        for row in first..t.rows.len() {
            t.set(row, "t_s", t.get(row, "t_s") + count);
            t.set(row, "pass", 1.0 + t.get(first - 1, "pass"));
        }
    }),
];

/// Every kind.
pub fn all() -> Vec<Damage> {
    let mut all: Vec<Damage> = (OF_ROWS.iter())
        .map(|(name, may_be_refused, act)| Damage {
            name: (*name).into(),
            act: Box::new(|table, random| {
                act(table, random);
                Vec::new()
            }),
            may_be_refused: *may_be_refused,
        })
        .collect();
    for (what, write, listed, refused) in OF_CELLS {
        for column in OF_COLUMNS {
            let count = if what.len() % 2 == 0 { 1 } else { 2 };
            all.push(Damage {
                name: format!("{count} of {column}: {what}"),
                act: Box::new(move |table, random| {
                    let rows = cells(table, random, column, count, write);
                    if listed { rows } else { Vec::new() }
                }),
                may_be_refused: refused && (column != "temperature_c" || what != "empty"),
            });
        }
    }
    all
}

/// Replaces `count` cells of a column; of a pair `measured` is one of its probes.
fn cells(
    table: &mut Table,
    random: &mut ChaCha8Rng,
    column: &str,
    count: usize,
    write: fn(f64, f64) -> String,
) -> Vec<usize> {
    let index = match column {
        "measured" => 3,
        "reference" => table.header.len() - 2,
        other => table.index(other),
    };
    let noise = match table.header[index] {
        "t_s" => 0.3,
        "temperature_c" => 0.02,
        "x1_mm" => table.noise * 12.0 / 206_265.0,
        _ => table.noise,
    };
    // Of less than twenty rows two are more than a tenth.
    let count = count.min(table.rows.len() / 10);
    let mut rows: Vec<usize> = (0..count).map(|_| random.random_range(0..table.rows.len())).collect();
    rows.sort_unstable();
    rows.dedup();
    for row in &rows {
        let value: f64 = table.rows[*row][index].parse().expect("a number");
        table.rows[*row][index] = write(value, noise);
    }
    rows
}

fn repeat(table: &mut Table, random: &mut ChaCha8Rng, count: usize) {
    let row = random.random_range(0..table.rows.len() - count);
    let again = table.rows[row..row + count].to_vec();
    table.rows.splice(row..row, again);
}

fn lose(table: &mut Table, random: &mut ChaCha8Rng, count: usize) -> Vec<Vec<String>> {
    let row = random.random_range(0..table.rows.len() - count);
    table.rows.drain(row..row + count).collect()
}

fn shift_time(table: &mut Table, random: &mut ChaCha8Rng, by: f64) {
    let from = random.random_range(1..table.rows.len());
    table.change("t_s", |row, v| if row >= from { v + by } else { v });
}

fn numbers(table: &Table, index: usize) -> Vec<f64> {
    table.rows.iter().map(|row| row[index].parse().expect("a number")).collect()
}

/// Holds a column at the value that `part` of its rows lie below.
fn cut(table: &mut Table, index: usize, part: f64) {
    let mut sorted = numbers(table, index);
    sorted.sort_unstable_by(f64::total_cmp);
    let limit = sorted[(part * (sorted.len() - 1) as f64) as usize];
    for (row, value) in numbers(table, index).into_iter().enumerate() {
        let held = if part > 0.5 { value.min(limit) } else { value.max(limit) };
        table.rows[row][index] = held.to_string();
    }
}

/// Rounds a column to a part of its range.
fn round(table: &mut Table, index: usize, part: f64) {
    let values = numbers(table, index);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let step = part * (high - low);
    for (row, value) in values.into_iter().enumerate() {
        table.rows[row][index] = ((value / step).round() * step).to_string();
    }
}
