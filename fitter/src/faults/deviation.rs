//! How far every row of a channel is from what the other rows say, in which the rows agree that predict it best.

use super::base::Base;
use super::scale::{least, median, quantile, range, scaled, trimmed, with_tail};
use super::{limits, trend};

/// What the rows of all channels have in common.
pub struct Surroundings {
    base: Base,
    time: Vec<f64>,
    /// The angle of every row, from −1 to 1.
    place: Vec<f64>,
    /// Rows by ascending angle, and where every row stands among them.
    by_angle: Vec<usize>,
    /// Rows after a turn of the movement, the first included: play may not be crossed there.
    turned: Vec<usize>,
    /// For every row the nearest angles of other rows: of either direction, and of its own.
    at_angle: [Vec<Vec<usize>>; 2],
}

/// Median of normal absolute values, over their standard deviation.
const MEDIAN: f64 = 0.6745;

/// How far a channel is from one prediction of it.
struct Prediction {
    scatter: f64,
    /// Which rows at the same angle were taken off before.
    kind: usize,
    /// Whether by a trend over the time.
    is_trend: bool,
    away: Vec<f64>,
}

/// Deviations of one channel.
pub struct Deviation {
    /// Value less its prediction; 0 of a blank.
    pub away: Vec<f64>,
    /// Whether a neighbour shares the deviation, or another prediction of the row sees none.
    pub shared: Vec<bool>,
    /// Scatter of such deviations around every row.
    pub scatter: Vec<f64>,
}

impl Surroundings {
    pub fn new(angle: &[f64], time: &[f64], direction: &[f64]) -> Surroundings {
        let n = angle.len();
        let mut steps: Vec<f64> =
            angle.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|s| *s > 0.0).collect();
        let same = limits::SAME_ANGLE * if steps.is_empty() { 0.0 } else { median(&mut steps) };
        // Rows at the same angle are ordered by the time: by the angle itself, which has noise, those would be nearest whose
        // noise is alike.
        let place = |row: usize| if same > 0.0 { (angle[row] / same).round() } else { angle[row] };
        let mut by_angle: Vec<usize> = (0..n).collect();
        by_angle.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
        let mut rank = vec![0; n];
        by_angle.iter().enumerate().for_each(|(k, row)| rank[*row] = k);
        let nearest = |row: usize, own: bool| {
            let mut found = Vec::with_capacity(limits::AT_ANGLE);
            let (mut below, mut above) = (rank[row], rank[row] + 1);
            // So far is looked at most: in one pass of one direction there may be nothing to be found.
            let end = (rank[row] + 4 * limits::AT_ANGLE + 8).min(n);
            let start = rank[row].saturating_sub(4 * limits::AT_ANGLE + 8);
            while found.len() < limits::AT_ANGLE && (below > start || above < end) {
                let distance = |other: usize| ((place(row) - place(other)).abs(), row.abs_diff(other));
                let low = (below > start).then(|| distance(by_angle[below - 1]));
                let high = (above < end).then(|| distance(by_angle[above]));
                let other = if high.is_none() || low.is_some_and(|low| high.is_some_and(|high| low <= high)) {
                    below -= 1;
                    by_angle[below]
                } else {
                    above += 1;
                    by_angle[above - 1]
                };
                let suits = !own || direction[other] == direction[row];
                if other.abs_diff(row) > limits::NEAR_IN_TIME && suits {
                    found.push(other);
                }
            }
            // Rows of the very angle are better witnesses than those of the next, if there are a few.
            let at_same = found.iter().filter(|other| (angle[**other] - angle[row]).abs() <= same).count();
            if at_same >= 2 {
                found.truncate(at_same);
            }
            found
        };
        // A row whose angle is far out, or far from those before and after, has no place among the others, nor a witness
        // at it: what wrong angles have in common is no sensor's.
        let (low, high) = range(angle);
        let jumps: Vec<f64> = less_in_time(angle, 2).iter().map(|jump| jump.abs()).collect();
        let mut sorted = jumps.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let step = if steps.is_empty() { 0.0 } else { median(&mut steps) };
        let farthest = limits::OUT_OF_PLACE * quantile(&sorted, 1.0 - limits::TAIL_PART).max(step);
        let has_place = |row: usize| (low..=high).contains(&angle[row]) && jumps[row] <= farthest;
        let of = |row: usize, own: bool| if has_place(row) { nearest(row, own) } else { Vec::new() };
        let at_angle = [false, true].map(|own| (0..n).map(|row| of(row, own)).collect());
        by_angle.retain(|row| has_place(*row));
        let place = scaled(angle).into_iter().map(|a| a.clamp(-1.0, 1.0)).collect();
        let turned = (0..n).filter(|row| *row == 0 || direction[*row] != direction[row - 1]).collect();
        let (base, time) = (Base::new(angle, time, direction), time.to_vec());
        Surroundings { base, time, place, by_angle, turned, at_angle }
    }

    /// The deviations of a channel; a blank deviates by nothing.
    pub fn deviation(&self, values: &[f64]) -> Deviation {
        let base = self.base.residual(values);
        let floor = least(values);
        // The channel as it is, less its smooth part, and less what the same angle says elsewhere; then less what the rows
        // before and after say.
        let at_angle = self.at_angle.iter().map(|at| less(&base, at));
        let by_angle: Vec<Vec<f64>> = [values.to_vec(), base.clone()].into_iter().chain(at_angle).collect();
        let mut predictions: Vec<Prediction> = Vec::new();
        let mut one_sided = Vec::new();
        for (kind, channel) in by_angle.iter().enumerate() {
            let medians = limits::WINDOWS.map(|window| (false, less_in_time(channel, window)));
            let [trend, before, after] = trend::less_trend(channel, &self.time);
            one_sided.push([before, after]);
            for (is_trend, away) in medians.into_iter().chain([(true, trend)]) {
                let mut absolute: Vec<f64> = away.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
                predictions.push(Prediction {
                    scatter: with_tail(&mut absolute).max(floor),
                    kind,
                    is_trend,
                    away,
                });
            }
        }
        predictions.sort_by(|a, b| a.scatter.total_cmp(&b.scatter));
        let Prediction { scatter: best, kind, is_trend, mut away } = predictions.remove(0);
        let scatter = self.scatter(&away, floor);
        let witnesses: Vec<&Vec<f64>> = predictions
            .iter()
            .filter(|other| other.scatter <= limits::WITNESS * best)
            .map(|other| &other.away)
            .collect();
        // Where the channel follows a trend its neighbours lie apart anyway.
        let beside_it = if is_trend { away.clone() } else { by_angle[kind].clone() };
        let mut shared = vec![false; away.len()];
        for row in 0..away.len() {
            let own = away[row];
            if !own.is_finite() || own.abs() < limits::CLOSER_LOOK * scatter[row] {
                continue;
            }
            let keeps = |other: f64| !other.is_finite() || other * own.signum() >= limits::ALONE * own.abs();
            let beside = [row.checked_sub(1), Some(row + 1)].into_iter().flatten();
            let alone =
                beside.filter_map(|other| beside_it.get(other)).all(|other| keeps(beside_it[row] - other));
            // What goes on from the rows of one side is a bend, not an outlier.
            let bent = one_sided[kind]
                .iter()
                .any(|side| side[row].is_finite() && side[row] * own.signum() < limits::BEND * own.abs());
            if bent || !alone || !witnesses.iter().all(|witness| keeps(witness[row])) {
                shared[row] = true;
            }
        }
        let in_time: Vec<usize> = (0..away.len()).collect();
        let sizes: Vec<f64> = away.iter().zip(&scatter).map(|(away, scatter)| away / scatter).collect();
        let either_sign = |own: f64, other: f64| other.abs() >= limits::CROWD_SIZE * own.abs();
        // What a cell far out leaves in the prediction of others at its angle is of the other sign.
        let same_sign = |own: f64, other: f64| other * own.signum() >= limits::CROWD_SIZE * own.abs();
        crowded(&sizes, &in_time, limits::CROWD, either_sign, &mut shared);
        crowded(&sizes, &self.by_angle, limits::CROWD_AT_ANGLE, same_sign, &mut shared);
        for (row, size) in sizes.iter().enumerate() {
            let again = |other: &usize| same_sign(*size, sizes[*other]);
            shared[row] |= size.abs() >= limits::CLOSER_LOOK && self.at_angle[0][row].iter().any(again);
        }
        away.iter_mut().filter(|away| !away.is_finite()).for_each(|away| *away = 0.0);
        Deviation { away, shared, scatter }
    }

    /// The scatter around every row: over the angle a smooth one, and larger where the rows nearby in time or in angle
    /// scatter more.
    fn scatter(&self, away: &[f64], floor: f64) -> Vec<f64> {
        let mut absolute: Vec<f64> = away.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
        let common = trimmed(&mut absolute).max(floor);
        let smooth = self.smooth_scatter(away, common);
        let in_time: Vec<usize> = (0..away.len()).collect();
        let size = |row: &usize| away[*row].abs() / smooth[*row];
        let mut larger = vec![1.0_f64; away.len()];
        for order in [&in_time, &self.by_angle] {
            let sizes: Vec<f64> = order.iter().map(size).collect();
            for (k, row) in order.iter().enumerate() {
                let start = k
                    .saturating_sub(limits::LOCAL_ROWS / 2)
                    .min(sizes.len().saturating_sub(limits::LOCAL_ROWS));
                let end = (start + limits::LOCAL_ROWS).min(sizes.len());
                let mut near: Vec<f64> =
                    sizes[start..end].iter().copied().filter(|r| r.is_finite()).collect();
                larger[*row] = larger[*row].max(limits::LOCAL_DISCOUNT * trimmed(&mut near));
            }
        }
        if self.turned.len() >= limits::TURNS {
            let mut sizes: Vec<f64> = self.turned.iter().map(size).filter(|size| size.is_finite()).collect();
            let here = median(&mut sizes) / MEDIAN;
            self.turned.iter().for_each(|row| larger[*row] = larger[*row].max(here));
        }
        smooth.iter().zip(larger).map(|(smooth, larger)| smooth * larger).collect()
    }

    /// A parabola over the angle through the sizes of the deviations, those beyond three times the scatter cut.
    fn smooth_scatter(&self, away: &[f64], common: f64) -> Vec<f64> {
        // Mean of normal absolute values, over their standard deviation.
        const MEAN: f64 = 0.797_88;
        let mut sums = nalgebra::Matrix2::zeros();
        let mut right = nalgebra::Vector2::zeros();
        for (r, x) in away.iter().zip(&self.place).filter(|(r, _)| r.is_finite()) {
            let column = nalgebra::Vector2::new(1.0, x * x);
            sums += column * column.transpose();
            right += column * (r.abs().min(3.0 * common) / MEAN);
        }
        match sums.lu().solve(&right) {
            Some(c) if away.len() >= 60 => {
                (self.place.iter()).map(|x| (c[0] + c[1] * x * x).max(limits::LEAST_LOCAL * common)).collect()
            }
            _ => vec![common; away.len()],
        }
    }
}

/// Every row less the median of the given others.
fn less(values: &[f64], others: &[Vec<usize>]) -> Vec<f64> {
    let mut near = Vec::new();
    (values.iter().zip(others))
        .map(|(value, others)| {
            near.clear();
            near.extend(others.iter().map(|other| values[*other]).filter(|v| v.is_finite()));
            if near.is_empty() { *value } else { value - median(&mut near) }
        })
        .collect()
}

/// Every row less the median of `window` rows before and after.
fn less_in_time(values: &[f64], window: usize) -> Vec<f64> {
    if window == 0 {
        let mut all: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let middle = median(&mut all);
        return values.iter().map(|value| value - middle).collect();
    }
    let mut near = Vec::new();
    (0..values.len())
        .map(|row| {
            near.clear();
            let range = row.saturating_sub(window)..(row + window + 1).min(values.len());
            near.extend(range.filter(|other| *other != row).map(|k| values[k]).filter(|v| v.is_finite()));
            if near.is_empty() { values[row] } else { values[row] - median(&mut near) }
        })
        .collect()
}

/// Marks rows far out that have several others nearly as far out around them, in multiples of the scatter: there the
/// scatter itself is larger.
fn crowded(
    sizes: &[f64],
    order: &[usize],
    most: usize,
    counts: impl Fn(f64, f64) -> bool,
    shared: &mut [bool],
) {
    let half = limits::LOCAL_ROWS / 2;
    for (k, row) in order.iter().enumerate() {
        let own = sizes[*row];
        if own.is_nan() || own.abs() < limits::CLOSER_LOOK {
            continue;
        }
        let near = &order[k.saturating_sub(half)..(k + half + 1).min(order.len())];
        let others = near.iter().filter(|other| counts(own, sizes[**other])).count() - 1;
        shared[*row] |= others > most;
    }
}
