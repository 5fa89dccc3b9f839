//! Whether held-out rows of both recordings are predicted better where a part may differ. A row that the others hardly determine
//! (its pass alone was as warm, or went as far) counts as little as its prediction is worth.

use numerics::rms;

use crate::held_out::{Gain, Groups, gain, groups};
use crate::noise::Noise;
use crate::rows::Rows;
use crate::thresholds::held_out::FOLDS;

use super::design::{Design, White};

/// What is left of held-out rows, in the later recording's unit; the earlier one's count by the ratio of their noise.
pub struct Proof {
    /// Root mean square with the part the same in both.
    pub without: f64,
    /// Where it may differ.
    pub with: f64,
    /// The mean difference over the groups that were held out.
    pub gain: Gain,
}

/// The rows of a recording that are held out together.
struct Held {
    /// The group of every row, and how many there are.
    group: Vec<usize>,
    count: usize,
    /// The fold of every row; none where nothing can be held out.
    fold: Vec<Option<usize>>,
}

impl Held {
    fn of(rows: &Rows) -> Held {
        let (group, count, by) = groups(rows, Groups::Passes);
        let folds = count.min(FOLDS);
        let fold = |g: &usize| if by == "pass" { g * folds / count } else { g % folds };
        let fold = group.iter().map(|g| (folds >= 2).then(|| fold(g))).collect();
        Held { group, count, fold }
    }
}

/// Holds out passes (or blocks) of both recordings in turn, and predicts them by the rest: with the parts `changed` differing,
/// and with `fewer` of them. None where nothing can be held out.
pub fn prove(
    design: &Design,
    noise: &[Noise; 2],
    unmeasured: &[usize],
    recordings: [&Rows; 2],
    changed: &[usize],
    fewer: &[usize],
) -> Option<Proof> {
    let held = recordings.map(Held::of);
    let folds: Vec<Option<usize>> = held.iter().flat_map(|held| held.fold.iter().copied()).collect();
    let clean = [&noise[0].clean[..], &noise[1].clean[..]].concat();
    let mut left = [vec![0.0; clean.len()], vec![0.0; clean.len()]];
    let mut weight = vec![1.0; clean.len()];
    for f in 0..FOLDS {
        let rows: Vec<usize> = (0..clean.len()).filter(|i| folds[*i] == Some(f)).collect();
        if rows.is_empty() {
            continue;
        }
        let white = White::new(noise, &[unmeasured, &rows[..]].concat());
        let [same, differing] = [fewer, changed].map(|differ| design.fit(&white, differ));
        let values = [same.value(), differing.value()];
        for i in rows {
            left.iter_mut().zip(&values).for_each(|(left, value)| left[i] = clean[i] - value[i]);
            let level = noise[usize::from(i >= design.both.split)].level;
            weight[i] = 1.0 / (1.0 + differing.variance(i) / (level * level));
        }
    }
    let mut groups_left = Vec::new();
    for (recording, held) in held.iter().enumerate() {
        if held.fold.iter().all(Option::is_none) {
            continue;
        }
        let scale = noise[1].level / noise[recording].level;
        let first = recording * design.both.split;
        for g in 0..held.count {
            let rows = || (0..held.group.len()).filter(|i| held.group[*i] == g).map(|i| first + i);
            let of = |left: &[f64]| {
                let sum: f64 = rows().map(|i| weight[i] * left[i] * left[i]).sum();
                scale * (sum / rows().count() as f64).sqrt()
            };
            groups_left.push([of(&left[0]), of(&left[1])]);
        }
    }
    let gains: Vec<f64> = groups_left.iter().map(|[same, changed]| same - changed).collect();
    let of = |k: usize| rms(&groups_left.iter().map(|left| left[k]).collect::<Vec<f64>>());
    (!gains.is_empty()).then(|| Proof { without: of(0), with: of(1), gain: gain(&gains) })
}
