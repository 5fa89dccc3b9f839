//! The main shares by schedule, by noise family and by temperature: where an answer goes wrong most.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Share, Unsealed};
use crate::answer::Answer;
use crate::truth::{Group, Truth};

/// Shares under one circumstance.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Breakdown {
    /// The circumstance.
    pub circumstance: String,
    /// False alarms on nulls.
    pub false_alarms: Share,
    /// Single effects of ρ ≥ 8, where the recording can tell: the right name first.
    pub named: Share,
    /// Two or three effects: the exact set.
    pub sets: Share,
    /// Physics outside the table: unexplained or partly explained.
    pub outside: Share,
}

pub(super) fn breakdown(cases: &[Case]) -> Vec<Breakdown> {
    type Kind = (&'static str, fn(&Truth) -> &str);
    let kinds: [Kind; 3] =
        [("schedule", |t| &t.schedule), ("noise", |t| &t.family), ("temperature", |t| &t.temperature)];
    let mut rows = Vec::new();
    for (kind, of) in kinds {
        let mut table: BTreeMap<&str, Breakdown> = BTreeMap::new();
        for case in cases {
            let row = table.entry(of(&case.truth)).or_default();
            count(case, row);
        }
        rows.extend(
            table.into_iter().map(|(name, row)| Breakdown { circumstance: format!("{kind}: {name}"), ..row }),
        );
    }
    rows
}

fn count(case: &Case, row: &mut Breakdown) {
    let truth = &case.truth;
    match truth.group {
        Group::Null => row.false_alarms.count(!case.said(|a| !a.detects())),
        Group::Strong if truth.can_tell() => {
            row.named.count(case.said(|a| a.first() == Some(&truth.effects[0].id)));
        }
        Group::Pair | Group::Triple if truth.can_tell() => {
            row.sets.count(case.said(|a| a.ids() == truth.ids()))
        }
        Group::Outside => row.outside.count(case.said(|a: &Answer| {
            use crate::answer::Verdict::{Described, PartlyExplained, Unexplained};
            matches!(a.verdict, Unexplained | PartlyExplained | Described)
        })),
        _ => {}
    }
}
