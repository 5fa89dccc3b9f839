//! Two recordings as one, with the columns that both have.

use numerics::range;

use crate::rows::{Column, Rows};
use crate::thresholds::compare::PAUSE;

/// Both recordings, in both orders: an effect with a memory begins in each as it does in that recording by itself, and what
/// it refers to (a mean temperature, the largest reading) is the same for both.
#[derive(Clone)]
pub struct Joined {
    /// The later after the earlier.
    pub rows: Rows,
    /// The earlier after the later.
    pub(super) swapped: Rows,
    /// The first row of the later in `rows`.
    pub split: usize,
}

impl Joined {
    /// Of the earlier and the later recording.
    pub fn new(then: &Rows, now: &Rows) -> Joined {
        Joined { rows: joined(then, now), swapped: joined(now, then), split: then.len() }
    }

    /// Columns over the rows of each recording, with that recording first.
    pub fn columns(&self, of: impl Fn(&Rows) -> Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        self.each_first(of(&self.rows), of(&self.swapped))
    }

    /// Columns over the rows of each recording, of those with the earlier first and those with the later first.
    pub(super) fn each_first(&self, mut columns: Vec<Vec<f64>>, swapped: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let n = self.rows.len() - self.split;
        columns.iter_mut().zip(swapped).for_each(|(c, later)| c[self.split..].copy_from_slice(&later[..n]));
        columns
    }

    /// A column in one of the recordings (0: then, 1: now) alone.
    pub(super) fn only(&self, recording: usize, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        let other = if recording == 0 { &mut column[self.split..] } else { &mut column[..self.split] };
        other.fill(0.0);
        column
    }

    /// Moves the true position of the later recording, where the reference was zeroed anew.
    pub fn move_zero(&mut self, by: f64) {
        let n = self.rows.len() - self.split;
        self.rows.truth[self.split..].iter_mut().for_each(|truth| *truth += by);
        self.swapped.truth[..n].iter_mut().for_each(|truth| *truth += by);
    }
}

/// One recording after the other. Their passes stay apart, and between them lies a time in which everything is forgotten.
fn joined(then: &Rows, now: &Rows) -> Rows {
    let of = |a: &[f64], b: &[f64]| [a, b].concat();
    let both = |a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| Some(of(a.as_ref()?, b.as_ref()?));
    let (_, last) = range(&then.t_s);
    let (first, _) = range(&now.t_s);
    let later = last - first + PAUSE * then.duration_s().max(now.duration_s());
    let passes = then.pass.iter().max().map_or(0, |most| most + 1) - now.pass.iter().min().unwrap_or(&0);
    let extra = then.extra.iter().filter_map(|column| {
        let other = now.extra.iter().find(|other| other.name == column.name)?;
        Some(Column { name: column.name.clone(), values: of(&column.values, &other.values) })
    });
    let between = 0.5 * (last + first + later);
    let pauses_s =
        then.pauses_s.iter().copied().chain([between]).chain(now.pauses_s.iter().map(|t| t + later));
    Rows {
        means: then.means || now.means,
        unit: then.unit.clone(),
        pair: then.pair,
        t_s: of(&then.t_s, &now.t_s.iter().map(|t| t + later).collect::<Vec<f64>>()),
        pauses_s: pauses_s.collect(),
        pass: then.pass.iter().copied().chain(now.pass.iter().map(|pass| pass + passes)).collect(),
        direction: of(&then.direction, &now.direction),
        reading: of(&then.reading, &now.reading),
        weight: of(&then.weight, &now.weight),
        theta: of(&then.theta, &now.theta),
        truth: of(&then.truth, &now.truth),
        error: of(&then.error, &now.error),
        common_mode_um: both(&then.common_mode_um, &now.common_mode_um),
        cross_arcsec: both(&then.cross_arcsec, &now.cross_arcsec),
        temperature_c: both(&then.temperature_c, &now.temperature_c),
        coil_a: both(&then.coil_a, &now.coil_a),
        command_deg: both(&then.command_deg, &now.command_deg),
        extra: extra.collect(),
        further_columns: 0,
        turn: then.turn.clone(),
        order: then.order.max(now.order),
        not_testable: Vec::new(),
    }
}

/// What both recorded, and over which range each did.
pub fn ranges(then: &Rows, now: &Rows) -> Vec<(String, [[f64; 2]; 2])> {
    let over = |v: &[f64]| <[f64; 2]>::from(range(v));
    let pair = |name: &str, a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| {
        Some((name.to_string(), [over(a.as_ref()?), over(b.as_ref()?)]))
    };
    let known = [
        pair("temperature_c", &then.temperature_c, &now.temperature_c),
        pair("common_mode_um", &then.common_mode_um, &now.common_mode_um),
        pair("cross_arcsec", &then.cross_arcsec, &now.cross_arcsec),
        pair("coil_a", &then.coil_a, &now.coil_a),
    ];
    let further = then.extra.iter().filter_map(|column| {
        let other = now.extra.iter().find(|other| other.name == column.name)?;
        Some((column.name.clone(), [over(&column.values), over(&other.values)]))
    });
    known.into_iter().flatten().chain(further).collect()
}
