//! Whether the later recording's held-out rows are predicted better where a part may differ.

use crate::held_out::{Gain, Groups, gain, groups};
use crate::noise::Noise;
use crate::numerics::{centred, rms};
use crate::rows::Rows;
use crate::thresholds::held_out::FOLDS;

use super::design::{Design, White};

/// What is left of held-out rows of the later recording, in its unit.
pub struct Proof {
    /// Root mean square with the part the same in both.
    pub without: f64,
    /// Where it may differ.
    pub with: f64,
    /// The mean difference over the groups that were held out.
    pub gain: Gain,
}

/// Holds out the later recording's passes (or blocks) in turn, and predicts them by the rest and the earlier recording: with the
/// parts `changed` differing, and with `fewer` of them. None where nothing can be held out.
pub fn prove(
    design: &Design,
    noise: &[Noise; 2],
    unmeasured: &[usize],
    now: &Rows,
    changed: &[usize],
    fewer: &[usize],
) -> Option<Proof> {
    let (group, count, by) = groups(now, Groups::Passes);
    let folds = count.min(FOLDS);
    if folds < 2 {
        return None;
    }
    let fold = |g: usize| if by == "pass" { g * folds / count } else { g % folds };
    let mut left = [vec![0.0; now.len()], vec![0.0; now.len()]];
    for f in 0..folds {
        let held: Vec<bool> = group.iter().map(|g| fold(*g) == f).collect();
        let rows = (0..now.len()).filter(|i| held[*i]).map(|i| design.both.split + i);
        let white = White::new(noise, &unmeasured.iter().copied().chain(rows).collect::<Vec<_>>());
        for (left, differ) in left.iter_mut().zip([fewer, changed]) {
            let value = design.fit(&white, differ).value();
            for (i, _) in held.iter().enumerate().filter(|(_, held)| **held) {
                left[i] = noise[1].clean[i] - value[design.both.split + i];
            }
        }
    }
    let of = |left: &[f64], g: usize| {
        let own: Vec<f64> = left.iter().zip(&group).filter(|(_, of)| **of == g).map(|(l, _)| *l).collect();
        rms(&own)
    };
    let gains: Vec<f64> = (0..count).map(|g| of(&left[0], g) - of(&left[1], g)).collect();
    let [without, with] = left.map(|left| rms(&centred(&left)));
    Some(Proof { without, with, gain: gain(&gains) })
}
