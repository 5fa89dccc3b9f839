//! Physics outside the table, and effects of the table that were left out of the catalogue: the right answer
//! is that nothing known explains it, and where it lives.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Figure, Share, Sheet, count};
use crate::answer::{Answer, Verdict};
use crate::truth::{CAN_TELL, Group};

/// ρ of what the closest effect of the table leaves, from which on structure beside it must be seen: that
/// from which on an effect must be detected.
const LEFT: f64 = 6.0;

/// Answers to one effect outside the table.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct OutsideRow {
    /// Its id.
    pub id: String,
    /// Trials of ρ ≥ 8 of which no effect of the table explains all but ρ 6.
    pub of: u64,
    /// Verdict `unexplained`.
    pub unexplained: u64,
    /// Verdict `partly_explained`.
    pub partly: u64,
    /// Verdict `explained`.
    pub named: u64,
    /// Verdict `consistent`, or refused.
    pub missed: u64,
    /// Of all of these, names of effects that leave less than ρ 4.1 of it: no recording like it can tell them apart.
    pub alike: u64,
    /// Trials of ρ ≥ 8 that an effect of the table imitates; not counted above.
    pub imitated: u64,
}

pub(super) fn figures(cases: &[Case], sheet: &mut Sheet) -> (Vec<OutsideRow>, Vec<OutsideRow>) {
    let left = |c: &Case| c.truth.effects[0].imitation.as_ref().is_none_or(|(_, left)| *left >= LEFT);
    let outside = || cases.iter().filter(|c| c.truth.group == Group::Outside && c.truth.least_rho() >= 8.0);
    let right = |c: &Case, a: &Answer| {
        matches!(a.verdict, Verdict::Unexplained | Verdict::PartlyExplained | Verdict::Described)
            && a.located_on(&c.truth.effects[0].depends_on)
    };
    let figure = ("outside the table, ρ ≥ 8: unexplained or partly explained, rightly located", 0.95);
    sheet.least(figure, "outside the table", outside().filter(|c| left(c)), right);
    let named = |_: &Case, a: &Answer| a.verdict == Verdict::Explained;
    let wrong = count(outside().filter(|c| left(c)), named);
    sheet.figures.push(Figure::at_most("outside the table: a wrong name alone", 0.02, wrong));
    let alike = |left: Option<f64>| left.is_some_and(|left| left < CAN_TELL);
    sheet.tell("a wrong name alone that leaves ρ ≥ 4.1 of it", outside().filter(|c| left(c)), |c, a| {
        named(c, a) && !alike(c.left_by_names[0])
    });
    sheet.tell("outside the table, those that an effect of it imitates included", outside(), right);

    let asked: Vec<(&Case, &Option<Answer>)> =
        cases.iter().filter_map(|c| c.without.as_ref().map(|answer| (c, answer))).collect();
    // What is a limiting case of another effect has a name without its own.
    let known =
        |c: &Case| crate::formulas::find(&c.truth.effects[0].id).is_some_and(|f| f.limit_of.is_some());
    let (mut share, mut apart) = (Share::default(), Share::default());
    for (case, answer) in asked.iter().filter(|(c, _)| left(c) && !known(c)) {
        let hit =
            answer.as_ref().is_some_and(|a| matches!(a.verdict, Verdict::Unexplained | Verdict::Described));
        share.count(hit);
        if hit || !alike(case.left_by_names[1]) {
            apart.count(hit);
        }
        if !hit {
            let said = answer.as_ref().map_or_else(|| "refused".to_owned(), Answer::sentence);
            let leaves = |left: f64| format!("{said}; of it these leave ρ {left:.1}");
            sheet.miss(
                "left out of the catalogue",
                *case,
                case.left_by_names[1].map_or(said.clone(), leaves),
            );
        }
    }
    if !asked.is_empty() {
        let apart = ("the same where other effects do not leave less than ρ 4.1 of it", apart);
        for (figure, share) in [("left out of the catalogue, ρ ≥ 8: unexplained", share), apart] {
            sheet.figures.push(Figure::reported(figure, share));
        }
    }
    let outside_rows = rows(outside().map(|c| (c, &c.answer, !left(c), alike(c.left_by_names[0]))));
    let without_rows =
        rows(asked.iter().map(|&(c, a)| (c, a, !left(c) || known(c), alike(c.left_by_names[1]))));
    (outside_rows, without_rows)
}

fn rows<'a>(answers: impl Iterator<Item = (&'a Case, &'a Option<Answer>, bool, bool)>) -> Vec<OutsideRow> {
    let mut rows: BTreeMap<&str, OutsideRow> = BTreeMap::new();
    for (case, answer, imitated, alike) in answers {
        let id = case.truth.effects[0].id.as_str();
        let row = rows.entry(id).or_insert_with(|| OutsideRow { id: id.to_owned(), ..OutsideRow::default() });
        if imitated {
            row.imitated += 1;
            continue;
        }
        row.of += 1;
        row.alike += u64::from(alike);
        match answer.as_ref().map(|a| a.verdict) {
            Some(Verdict::Unexplained) => row.unexplained += 1,
            Some(Verdict::PartlyExplained | Verdict::Described) => row.partly += 1,
            Some(Verdict::Explained) => row.named += 1,
            Some(Verdict::Consistent) | None => row.missed += 1,
        }
    }
    rows.into_values().collect()
}
