//! Calibration points: which rows were taken at the same commanded angle, and the blocks that take their
//! place where no angle repeats.

use std::collections::HashMap;

use crate::recording::Recording;

/// What the rows are grouped by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grouping {
    /// Rows of one commanded angle, as `command_deg` states it.
    Commanded,
    /// Rows of one angle, recognised by their readings, where `command_deg` is missing.
    Reading,
    /// Contiguous blocks of rows: no angle repeats.
    Block,
}

impl Grouping {
    /// As it stands in the coefficients file and in messages.
    pub fn name(self) -> &'static str {
        match self {
            Grouping::Commanded => "commanded angle",
            Grouping::Reading => "angle, by reading",
            Grouping::Block => "contiguous block",
        }
    }
}

/// The rows of a recording, grouped.
#[derive(Debug, Clone)]
pub struct Points {
    /// What a group is.
    pub grouping: Grouping,
    /// The group of every row; groups are numbered by ascending mean reading.
    pub of_row: Vec<u32>,
    /// Mean reading of every group.
    pub reading: Vec<f64>,
    /// Number of rows of every group.
    pub rows: Vec<usize>,
    /// Whether a group is one angle, rather than a bundle of neighbouring ones (or a block).
    pub single_angles: bool,
}

/// At most so many groups: beyond, neighbouring angles are bundled. A held-out bundle still holds every
/// reading of its angles.
const MOST_POINTS: usize = 1024;
/// So many blocks at most where no angle repeats, and so many rows at least in each.
const MOST_BLOCKS: usize = 40;
const BLOCK_ROWS: usize = 4;
/// So many bundles at most of a turn on which no angle repeats: 1.4 degrees each.
const MOST_BUNDLES: usize = 256;

impl Points {
    /// Groups the rows of a recording; `reading` is [`Recording::reading`] of every row.
    pub fn of(recording: &Recording, reading: &[f64]) -> Points {
        let by_command = recording.command_deg.as_deref().and_then(commanded);
        let grouping = if by_command.is_some() { Grouping::Commanded } else { Grouping::Reading };
        let keys = by_command.unwrap_or_else(|| clusters(recording, reading));
        if repeats(&keys, &recording.pass) {
            Points::from_keys(grouping, keys, reading)
        } else {
            let keys = blocks(&recording.pass);
            Points { single_angles: false, ..Points::from_keys(Grouping::Block, keys, reading) }
        }
    }

    /// Groups the readings of a sensor that turns, given within the turn: by angle where the same angles come
    /// again, pass by pass or turn by turn, else in bundles of neighbouring ones. An angle is the same
    /// whichever turn was commanded.
    pub fn around(recording: &Recording, reading: &[f64], turn: f64) -> Points {
        let mut steps: Vec<f64> = (1..reading.len())
            .filter(|row| recording.pass[*row] == recording.pass[row - 1])
            .map(|row| reading[row] - reading[row - 1])
            .map(|step| (step - turn * (step / turn).round()).abs())
            .filter(|step| *step > 0.0)
            .collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        let keys = gathered(reading, 0.25 * step);
        let count = keys.iter().max().map_or(0, |key| *key as usize + 1);
        // Steps that are out of step from turn to turn run together, into few groups or into none.
        let apart = count as f64 * step >= 0.5 * turn;
        if apart && 2 * reading.len() >= 3 * count {
            return Points::from_keys(Grouping::Reading, keys, reading);
        }
        let mut order: Vec<usize> = (0..reading.len()).collect();
        order.sort_by(|a, b| reading[*a].total_cmp(&reading[*b]));
        let bundles = reading.len().min(MOST_BUNDLES);
        let mut keys = vec![0; reading.len()];
        for (position, row) in order.into_iter().enumerate() {
            keys[row] = (position * bundles / reading.len()) as u32;
        }
        Points { single_angles: false, ..Points::from_keys(Grouping::Reading, keys, reading) }
    }

    /// Number of groups.
    pub fn count(&self) -> usize {
        self.reading.len()
    }

    fn from_keys(grouping: Grouping, mut keys: Vec<u32>, reading: &[f64]) -> Points {
        let count = keys.iter().max().map_or(0, |key| *key as usize + 1);
        let (mut sum, mut rows) = (vec![0.0; count], vec![0usize; count]);
        for (key, x) in keys.iter().zip(reading) {
            sum[*key as usize] += x;
            rows[*key as usize] += 1;
        }
        let mean: Vec<f64> = sum.iter().zip(&rows).map(|(sum, rows)| sum / *rows as f64).collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| mean[*a].total_cmp(&mean[*b]));
        let bundles = count.min(MOST_POINTS);
        let mut rank = vec![0u32; count];
        let mut points = Points {
            grouping,
            of_row: Vec::new(),
            reading: vec![0.0; bundles],
            rows: vec![0; bundles],
            single_angles: bundles == count,
        };
        for (position, old) in order.into_iter().enumerate() {
            let new = position * bundles / count;
            rank[old] = new as u32;
            points.reading[new] += sum[old];
            points.rows[new] += rows[old];
        }
        points.reading.iter_mut().zip(&points.rows).for_each(|(sum, rows)| *sum /= *rows as f64);
        keys.iter_mut().for_each(|key| *key = rank[*key as usize]);
        points.of_row = keys;
        points
    }
}

/// One number per distinct commanded angle (to a millionth of a degree), `None` if a cell is blank.
fn commanded(command_deg: &[f64]) -> Option<Vec<u32>> {
    let mut known: HashMap<i64, u32> = HashMap::new();
    let mut last = (i64::MIN, 0);
    command_deg
        .iter()
        .map(|angle| {
            if angle.is_nan() {
                return None;
            }
            let rounded = (angle * 1e6).round() as i64;
            if rounded != last.0 {
                let next = known.len() as u32;
                last = (rounded, *known.entry(rounded).or_insert(next));
            }
            Some(last.1)
        })
        .collect()
}

/// Clusters of readings: within one pass neighbouring angles are some step apart, and what lies closer
/// than a quarter of the typical step is the same angle.
fn clusters(recording: &Recording, reading: &[f64]) -> Vec<u32> {
    let order = ordered(reading.len(), |a, b| {
        (recording.pass[a].cmp(&recording.pass[b])).then(reading[a].total_cmp(&reading[b]))
    });
    let rows = order.windows(2).map(|pair| [pair[0] as usize, pair[1] as usize]);
    let mut steps: Vec<f64> = rows
        .filter(|[before, row]| recording.pass[*before] == recording.pass[*row])
        .map(|[before, row]| reading[row] - reading[before])
        .collect();
    drop(order);
    steps.sort_unstable_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    drop(steps);
    gathered(reading, 0.25 * step)
}

/// One number per cluster of readings that lie no further apart than `tolerance`, ascending.
fn gathered(reading: &[f64], tolerance: f64) -> Vec<u32> {
    let order = ordered(reading.len(), |a, b| reading[a].total_cmp(&reading[b]));
    let mut keys = vec![0; reading.len()];
    let mut key = 0;
    for rows in order.windows(2) {
        let [before, row] = [rows[0] as usize, rows[1] as usize];
        key += u32::from(reading[row] - reading[before] > tolerance);
        keys[row] = key;
    }
    keys
}

/// Rows in an order, in half of the memory that indices take: of ten million rows that is what a gibibyte has left.
fn ordered(rows: usize, order: impl Fn(usize, usize) -> std::cmp::Ordering) -> Vec<u32> {
    let mut ordered: Vec<u32> = (0..rows as u32).collect();
    ordered.sort_unstable_by(|a, b| order(*a as usize, *b as usize));
    ordered
}

/// Whether most rows have a partner from another pass in their group, and groups are not nearly all.
fn repeats(keys: &[u32], pass: &[i32]) -> bool {
    let count = keys.iter().max().map_or(0, |key| *key as usize + 1);
    let mut first: Vec<Option<i32>> = vec![None; count];
    let (mut shared, mut rows) = (vec![false; count], vec![0usize; count]);
    for (key, pass) in keys.iter().zip(pass) {
        let key = *key as usize;
        rows[key] += 1;
        shared[key] |= *first[key].get_or_insert(*pass) != *pass;
    }
    let partnered: usize =
        rows.iter().zip(&shared).filter(|(_, shared)| **shared).map(|(rows, _)| rows).sum();
    count >= 3 && 2 * partnered > keys.len()
}

/// Contiguous blocks of rows that do not cross from one pass into the next.
fn blocks(pass: &[i32]) -> Vec<u32> {
    let wanted = (pass.len() / BLOCK_ROWS).clamp(1, MOST_BLOCKS);
    let mut keys = Vec::with_capacity(pass.len());
    let mut key = 0;
    let mut start = 0;
    for row in 0..pass.len() {
        let full = (row - start) * wanted >= pass.len();
        if row > 0 && (pass[row] != pass[row - 1] || full) {
            key += 1;
            start = row;
        }
        keys.push(key);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_contiguous_and_stay_inside_a_pass() {
        let pass: Vec<i32> = (0..400).map(|row| row / 150).collect();
        let keys = blocks(&pass);
        assert!(keys.windows(2).all(|k| k[1] == k[0] || k[1] == k[0] + 1));
        for (row, key) in keys.iter().enumerate().skip(1) {
            assert!(*key != keys[row - 1] || pass[row] == pass[row - 1]);
        }
        assert!((30..=43).contains(&(*keys.last().unwrap() as usize)));
    }

    #[test]
    fn a_commanded_angle_is_one_group_whatever_its_last_bit() {
        assert_eq!(commanded(&[-1.7, 0.1 + 0.2, 0.3, -1.7]), Some(vec![0, 1, 1, 0]));
        assert_eq!(commanded(&[-1.7, f64::NAN]), None);
    }
}
