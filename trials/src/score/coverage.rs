//! Whether the 95 % intervals hold the truth, wherever a concealed effect was named.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Figure, Share};
use crate::statistics::binomial_p_value;

/// What the intervals claim.
const CLAIMED: f64 = 0.95;
/// The chance of calling any parameter inconsistent although all are right, over all of them.
const OVER_ALL: f64 = 0.01;

/// Coverage of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Covered {
    /// The effect.
    pub id: String,
    /// The parameter.
    pub parameter: String,
    /// How many intervals hold the truth.
    pub share: Share,
    /// Two-sided binomial p-value against 95 %.
    pub p_value: f64,
    /// Whether it is consistent with 95 %, at 1 % over all parameters.
    pub consistent: bool,
}

pub(super) fn figures(cases: &[Case], figures: &mut Vec<Figure>) -> Vec<Covered> {
    let mut shares: BTreeMap<(String, String), Share> = BTreeMap::new();
    let mut pooled = Share::default();
    for case in cases.iter().filter(|c| !c.truth.ambiguous()) {
        let Some(answer) = &case.answer else { continue };
        for effect in &case.truth.effects {
            let Some(named) = answer.effects.iter().find(|n| n.id == effect.id) else { continue };
            // A number of harmonics is counted, not measured.
            for parameter in named.parameters.iter().filter(|p| p.name != "harmonics") {
                let Some(truth) = effect.parameters.get(&parameter.name) else { continue };
                let [from, to] = parameter.ci95;
                let hit = from <= *truth && *truth <= to;
                shares.entry((effect.id.clone(), parameter.name.clone())).or_default().count(hit);
                pooled.count(hit);
            }
        }
    }
    let count = shares.len().max(1) as f64;
    let rows: Vec<Covered> = shares
        .into_iter()
        .map(|((id, parameter), share)| {
            let p_value = binomial_p_value(share.hits, share.of, CLAIMED);
            Covered { id, parameter, share, p_value, consistent: p_value >= OVER_ALL / count }
        })
        .collect();
    figures.push(Figure {
        figure: "coverage of the 95 % intervals, pooled".to_owned(),
        wanted: "93–97 %".to_owned(),
        measured: pooled.to_string(),
        passed: pooled.value().map(|value| (0.93..=0.97).contains(&value)),
    });
    let wrong: Vec<String> =
        rows.iter().filter(|r| !r.consistent).map(|r| format!("{} {}", r.id, r.parameter)).collect();
    figures.push(Figure {
        figure: "parameters whose coverage is inconsistent with 95 % (binomial, 1 % over all)".to_owned(),
        wanted: "none".to_owned(),
        measured: match wrong.len() {
            0 => format!("none of {}", rows.len()),
            wrong_count => format!("{wrong_count} of {}: {}", rows.len(), wrong.join(", ")),
        },
        passed: (!rows.is_empty()).then_some(wrong.is_empty()),
    });
    rows
}
