//! One physics to which each recording gave a name of its own.

use crate::calibrate::log_tail;
use crate::effects::Effect;
use crate::intervals::widening;
use crate::thresholds::compare::{ALTERNATIVE, FALSE_ALARMS};

use super::design::{Design, What, White};

/// The model in which an effect that only the earlier recording named, and one that only the later one did, are one, wherever
/// one of them does for both recordings: the other is then needed no more than by chance.
pub fn one_name_for_both<'a>(mut design: Design<'a>, white: &White, freedom: f64) -> Design<'a> {
    while let Some(fewer) = with_one_less(&design, white, freedom) {
        design = fewer;
    }
    design
}

fn with_one_less<'a>(design: &Design<'a>, white: &White, freedom: f64) -> Option<Design<'a>> {
    let only = |recording: usize| {
        let found = move |k: &usize| {
            let found = &design.shared[*k].found;
            found[recording].is_some() && found[1 - recording].is_none()
        };
        (0..design.shared.len()).filter(found)
    };
    let all = only(0).next().and(only(1).next()).map(|_| settled(design.clone(), white).1)?;
    let pairs = only(0).flat_map(|then| only(1).flat_map(move |now| [(then, now), (now, then)]));
    let wide = widening(freedom).powi(2);
    let fewer = pairs.filter_map(|(kept, dropped)| {
        let part = design.part(What::Amplitude(dropped))?;
        // In each recording.
        let rank = 2 * design.parts[part].columns.len();
        let (fewer, left) = settled(design.with_one(kept, dropped), white);
        let chance = log_tail((left - all) / wide, rank) < -FALSE_ALARMS.ln();
        // After Akaike a column must be worth 2. A name comes before a form that does nearly as well.
        let columns = 2 * design.parts[design.part(What::Amplitude(kept))?].columns.len();
        let form = design.shared[kept].effect.as_ref().is_none_or(Effect::is_form);
        let handicap = if form { 2.0 * ALTERNATIVE } else { 0.0 };
        chance.then_some((left + 2.0 * columns as f64 + handicap, fewer))
    });
    fewer.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, fewer)| fewer)
}

/// With every effect about its own strength in each recording, and what is left then, in units of the noise.
fn settled<'a>(mut design: Design<'a>, white: &White) -> (Design<'a>, f64) {
    let amplitudes = design.amplitudes();
    design.settle(white, &amplitudes);
    let left = design.fit(white, &design.parts_of(&amplitudes)).solution.rss;
    (design, left)
}
