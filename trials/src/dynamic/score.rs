//! What counts as right in dynamic trials, figure by figure.

use std::collections::BTreeMap;

use serde::Serialize;

use super::truth::{Group, Truth};
use crate::answer::{Answer, Verdict};
use crate::score::{Figure, Miss, Share, Sheet, Unsealed};
use crate::statistics::percentile;

/// Free run over noise that is allowed.
const LEFT: f64 = 1.05;

/// One trial, unsealed.
pub struct Case {
    /// What was concealed.
    pub truth: Truth,
    /// What was said; none where the recording was refused.
    pub answer: Option<Answer>,
    /// Root mean square that the augmented plant's free run leaves, in the position unit.
    pub left: Option<f64>,
}

impl Case {
    /// What the free run leaves, over the noise that is in the recording.
    fn ratio(&self) -> Option<f64> {
        self.left.map(|left| left / self.truth.noise_rms)
    }
}

impl Unsealed for Case {
    fn answer(&self) -> Option<&Answer> {
        self.answer.as_ref()
    }

    fn described(&self) -> (String, Vec<String>, String) {
        let t = &self.truth;
        let effect = |e: &super::truth::Concealed| {
            let near =
                e.imitation.as_ref().map_or(String::new(), |(id, left)| format!(", {id} leaves {left:.0}"));
            format!("{} (ρ {:.0}, {:.1} rms{near})", e.id, e.rho, e.effect_rms)
        };
        let circumstances = format!("{}, {}, {}", t.noise, t.excitation, t.hold);
        (t.recording.clone(), t.effects.iter().map(effect).collect(), circumstances)
    }

    fn sentence(&self) -> String {
        let said = self.answer.as_ref().map_or_else(|| String::from("refused"), Answer::sentence);
        let run = self.ratio().map(|ratio| format!(" · free run {ratio:.3} × noise"));
        said + &run.unwrap_or_default()
    }
}

/// Answers to one effect, or to one circumstance.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Row {
    /// The id, or the circumstance.
    pub name: String,
    /// Right answers.
    pub right: Share,
    /// Right answers where those that nobody can tell count by their alternatives.
    pub mentioned: Share,
}

/// Everything that was measured.
#[derive(Serialize)]
pub struct Score {
    /// The summary.
    pub figures: Vec<Figure>,
    /// By concealed effect, singles and physics outside the table.
    pub effects: Vec<Row>,
    /// By noise, excitation and hold, singles only.
    pub circumstances: Vec<Row>,
    /// Every answer that was not right.
    pub misses: Vec<Miss>,
}

/// Whether the answer names exactly the concealed effects, where those that nobody can tell may stand among the
/// alternatives of another name.
fn names_all(truth: &Truth, answer: &Answer) -> bool {
    answer.effects.len() == truth.effects.len()
        && matches(truth, answer, &mut vec![false; truth.effects.len()])
}

/// Finds a named effect for each concealed one; there are two at most, so that trying all is quick.
fn matches(truth: &Truth, answer: &Answer, used: &mut Vec<bool>) -> bool {
    let done = used.iter().filter(|u| **u).count();
    let Some(effect) = truth.effects.get(done) else { return true };
    (0..answer.effects.len()).any(|index| {
        let named = &answer.effects[index];
        let listed = !effect.can_tell() && named.alternatives.contains(&effect.id);
        if used[index] || !(named.id == effect.id || listed) {
            return false;
        }
        used[index] = true;
        let rest = matches(truth, answer, used);
        used[index] = rest;
        rest
    })
}

/// Scores the cases.
pub fn score(cases: &[Case]) -> Score {
    let mut sheet = Sheet::default();
    let of = |group: Group| cases.iter().filter(move |c| c.truth.group == group);

    let quiet = sheet.share("false alarm", of(Group::Null), |_, a| !a.detects());
    let alarms = Share { hits: quiet.of - quiet.hits, of: quiet.of };
    sheet.figures.push(Figure::at_most("false alarms on nulls", 0.01, alarms));

    let first = |c: &Case, a: &Answer| a.first() == Some(c.truth.effects[0].id.as_str());
    let distinguishable = of(Group::Single).filter(|c| c.truth.can_tell());
    let figure = ("single effects named first, where the recording can tell", 0.95);
    sheet.least(figure, "named first", distinguishable, first);
    let figure = ("single effects named, or listed beside one that nobody can tell from it", 0.95);
    sheet.least(figure, "named or listed", of(Group::Single), |c, a| {
        first(c, a) || (!c.truth.can_tell() && a.mentions(&c.truth.effects[0].id))
    });
    let all = |c: &Case, a: &Answer| names_all(&c.truth, a);
    sheet.tell("single effects: that one name and no other", of(Group::Single), all);

    sheet.least(("pairs: both named and nothing else", 0.85), "pair", of(Group::Pair), all);
    let tellable = of(Group::Pair).filter(|c| c.truth.can_tell());
    sheet.tell("pairs, where the recording can tell", tellable, all);

    let unnamed = |_: &Case, a: &Answer| a.names_nothing();
    let figure = ("outside the table: unexplained, or described without a name", 0.95);
    sheet.least(figure, "outside", of(Group::Outside), unnamed);
    sheet.tell("outside the table: a wrong name alone", of(Group::Outside), |_, a| {
        a.verdict == Verdict::Explained
    });
    sheet.tell("outside the table: rightly located", of(Group::Outside), |c, a| {
        a.located_on(&c.truth.effects[0].depends_on)
    });

    let run = || cases.iter().filter(|c| matches!(c.truth.group, Group::Single | Group::Pair));
    let figure = ("free run after ≤ 1.05 × the noise, singles and pairs", 0.95);
    sheet.least(figure, "free run", run(), |c, _| c.ratio().is_some_and(|ratio| ratio <= LEFT));
    let ratios: Vec<f64> = run().filter_map(Case::ratio).collect();
    let median = percentile(&ratios, 0.5).map_or(String::from("none"), |median| format!("{median:.4}"));
    sheet.figures.push(Figure::noted("free run after over the noise, median", median));

    let effects = rows(cases, |c| match c.truth.group {
        Group::Single | Group::Outside => vec![c.truth.effects[0].id.clone()],
        _ => Vec::new(),
    });
    let circumstances = rows(cases, |c| match c.truth.group {
        Group::Single => vec![
            format!("noise: {}", c.truth.noise),
            format!("excitation: {}", c.truth.excitation),
            format!("drive: {}", c.truth.hold),
        ],
        _ => Vec::new(),
    });
    let Sheet { figures, misses } = sheet;
    Score { figures, effects, circumstances, misses }
}

fn rows(cases: &[Case], names: impl Fn(&Case) -> Vec<String>) -> Vec<Row> {
    let mut table: BTreeMap<String, Row> = BTreeMap::new();
    for case in cases {
        for name in names(case) {
            let id = case.truth.effects[0].id.as_str();
            let outside = case.truth.group == Group::Outside;
            let right = case.said(|a| if outside { a.names_nothing() } else { a.first() == Some(id) });
            let row = table.entry(name.clone()).or_insert_with(|| Row { name, ..Row::default() });
            row.right.count(right);
            row.mentioned
                .count(right || (!outside && case.said(|a| !case.truth.can_tell() && a.mentions(id))));
        }
    }
    table.into_values().collect()
}

#[cfg(test)]
pub(super) mod tests;
