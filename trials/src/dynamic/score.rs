//! What counts as right in dynamic trials, figure by figure.

use std::collections::BTreeMap;

use serde::Serialize;

use super::truth::{Group, Truth};
use crate::answer::{Answer, Verdict};
use crate::score::{Figure, Miss, Share};
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
    fn said(&self, right: impl Fn(&Answer) -> bool) -> bool {
        self.answer.as_ref().is_some_and(right)
    }

    /// What the free run leaves, over the noise that is in the recording.
    fn ratio(&self) -> Option<f64> {
        self.left.map(|left| left / self.truth.noise_rms)
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
    let mut misses = Vec::new();
    let mut figures = Vec::new();
    let of = |group: Group| cases.iter().filter(move |c| c.truth.group == group);
    let mut share = |figure: &'static str, cases: Vec<&Case>, right: &dyn Fn(&Case, &Answer) -> bool| {
        let mut share = Share::default();
        for case in cases {
            let hit = case.said(|answer| right(case, answer));
            share.count(hit);
            if !hit {
                misses.push(miss(figure, case));
            }
        }
        share
    };

    let quiet = share("false alarm", of(Group::Null).collect(), &|_, a| !a.detects());
    let alarms = Share { hits: quiet.of - quiet.hits, of: quiet.of };
    figures.push(Figure {
        figure: String::from("false alarms on nulls"),
        wanted: String::from("≤ 1 %"),
        measured: alarms.to_string(),
        passed: alarms.value().map(|value| value <= 0.01),
    });

    let first = |c: &Case, a: &Answer| a.first() == Some(c.truth.effects[0].id.as_str());
    let told = || of(Group::Single).filter(|c| c.truth.can_tell());
    let named = share("named first", told().collect(), &first);
    figures.push(Figure::at_least("single effects named first, where the recording can tell", 0.95, named));
    let mentioned = share("named or listed", of(Group::Single).collect(), &|c, a| {
        first(c, a) || (!c.truth.can_tell() && a.mentions(&c.truth.effects[0].id))
    });
    figures.push(Figure::at_least(
        "single effects named, or listed beside one that nobody can tell from it",
        0.95,
        mentioned,
    ));
    figures.push(Figure::reported(
        "single effects: that one name and no other",
        count(of(Group::Single), names_all),
    ));

    let pairs = share("pair", of(Group::Pair).collect(), &|c, a| names_all(&c.truth, a));
    figures.push(Figure::at_least("pairs: both named and nothing else", 0.85, pairs));
    let tellable = of(Group::Pair).filter(|c| c.truth.can_tell());
    figures.push(Figure::reported("pairs, where the recording can tell", count(tellable, names_all)));

    let outside = share("outside", of(Group::Outside).collect(), &|_, a| a.verdict == Verdict::Unexplained);
    figures.push(Figure::at_least("outside the table: unexplained", 0.95, outside));
    let wrong = count(of(Group::Outside), |_, a| a.verdict == Verdict::Explained);
    figures.push(Figure::reported("outside the table: a wrong name alone", wrong));
    let located = count(of(Group::Outside), |t, a| a.located_on(&t.effects[0].depends_on));
    figures.push(Figure::reported("outside the table: rightly located", located));

    let within = |c: &Case| c.ratio().is_some_and(|ratio| ratio <= LEFT);
    let run = |c: &&Case| matches!(c.truth.group, Group::Single | Group::Pair);
    let left = share("free run", cases.iter().filter(run).collect(), &|c, _| within(c));
    figures.push(Figure::at_least("free run after ≤ 1.05 × the noise, singles and pairs", 0.95, left));
    let ratios: Vec<f64> = cases.iter().filter(run).filter_map(Case::ratio).collect();
    let median = percentile(&ratios, 0.5).map_or(String::from("none"), |median| format!("{median:.4}"));
    figures.push(Figure {
        figure: String::from("free run after over the noise, median"),
        wanted: String::from("–"),
        measured: median,
        passed: None,
    });

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
    Score { figures, effects, circumstances, misses }
}

fn count<'a>(cases: impl Iterator<Item = &'a Case>, right: impl Fn(&Truth, &Answer) -> bool) -> Share {
    let mut share = Share::default();
    cases.for_each(|case| share.count(case.said(|answer| right(&case.truth, answer))));
    share
}

fn rows(cases: &[Case], names: impl Fn(&Case) -> Vec<String>) -> Vec<Row> {
    let mut table: BTreeMap<String, Row> = BTreeMap::new();
    for case in cases {
        for name in names(case) {
            let id = case.truth.effects[0].id.as_str();
            let outside = case.truth.group == Group::Outside;
            let right = case
                .said(|a| if outside { a.verdict == Verdict::Unexplained } else { a.first() == Some(id) });
            let row = table.entry(name.clone()).or_insert_with(|| Row { name, ..Row::default() });
            row.right.count(right);
            row.mentioned
                .count(right || (!outside && case.said(|a| !case.truth.can_tell() && a.mentions(id))));
        }
    }
    table.into_values().collect()
}

fn miss(figure: &'static str, case: &Case) -> Miss {
    let t = &case.truth;
    let effect = |e: &super::truth::Concealed| {
        let near =
            e.imitation.as_ref().map_or(String::new(), |(id, left)| format!(", {id} leaves {left:.0}"));
        format!("{} (ρ {:.0}, {:.1} rms{near})", e.id, e.rho, e.effect_rms)
    };
    let concealed = match t.effects.len() {
        0 => String::from("nothing"),
        _ => t.effects.iter().map(effect).collect::<Vec<_>>().join(" + "),
    };
    let mut said = case.answer.as_ref().map_or_else(|| String::from("refused"), Answer::sentence);
    if let Some(ratio) = case.ratio() {
        said += &format!(" · free run {ratio:.3} × noise");
    }
    Miss {
        figure,
        recording: t.recording.clone(),
        concealed,
        said,
        circumstances: format!("{}, {}, {}", t.noise, t.excitation, t.hold),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::dynamic::truth::Concealed;

    fn concealed(id: &str, left: f64) -> Concealed {
        Concealed {
            id: id.to_owned(),
            parameters: BTreeMap::new(),
            effect_rms: 10.0,
            rho: 1000.0,
            depends_on: vec![String::from("drive")],
            imitation: Some((String::from("sensor_lag"), left)),
        }
    }

    pub fn case(group: Group, effects: Vec<Concealed>, answer: &str, left: f64) -> Case {
        let truth = Truth {
            recording: String::from("r000001.csv.gz"),
            group,
            noise: String::from("white"),
            excitation: String::from("multisine"),
            hold: String::from("zero-order"),
            noise_rms: 0.9,
            effects,
        };
        Case { truth, answer: serde_json::from_str(answer).ok(), left: Some(left) }
    }

    pub fn said(verdict: &str, effects: &[(&str, &[&str])]) -> String {
        let effects: Vec<String> = effects
            .iter()
            .map(|(id, alternatives)| {
                format!("{{\"id\": \"{id}\", \"parameters\": [], \"alternatives\": {alternatives:?}}}")
            })
            .collect();
        format!(
            "{{\"verdict\": \"{verdict}\", \"locations\": [{{\"variable\": \"drive\"}}], \"effects\": [{}], \"fit\": \
             {{\"before\": {{\"held_out_rms\": 1}}, \"after\": {{\"held_out_rms\": 1}}}}}}",
            effects.join(", ")
        )
    }

    fn passed(score: &Score, figure: &str) -> Option<bool> {
        score.figures.iter().find(|f| f.figure.starts_with(figure)).unwrap().passed
    }

    #[test]
    fn right_answers_pass_and_wrong_ones_fail() {
        let friction = || vec![concealed("coulomb_friction", 900.0)];
        let lag = || vec![concealed("drive_lag", 1.0)];
        let right = [
            case(Group::Null, Vec::new(), &said("consistent", &[]), 0.9),
            case(Group::Single, friction(), &said("explained", &[("coulomb_friction", &[])]), 0.91),
            case(Group::Single, lag(), &said("explained", &[("sensor_lag", &["drive_lag"])]), 0.9),
            case(
                Group::Pair,
                vec![concealed("drive_lag", 1.0), concealed("cogging", 900.0)],
                &said("explained", &[("cogging", &[]), ("sensor_lag", &["drive_lag"])]),
                0.9,
            ),
            case(Group::Outside, vec![concealed("ooc_dead_zone", 900.0)], &said("unexplained", &[]), 50.0),
        ];
        let score_right = score(&right);
        assert!(score_right.figures.iter().all(|f| f.passed != Some(false)), "{:?}", score_right.figures);
        assert!(score_right.misses.is_empty());

        let wrong = [
            case(Group::Null, Vec::new(), &said("explained", &[("cogging", &[])]), 0.9),
            case(Group::Single, friction(), &said("explained", &[("drive_lag", &["coulomb_friction"])]), 2.0),
            case(
                Group::Pair,
                vec![concealed("cogging", 900.0); 2],
                &said("explained", &[("cogging", &[])]),
                0.9,
            ),
            case(Group::Outside, vec![concealed("ooc_dead_zone", 900.0)], "", 50.0),
        ];
        let score_wrong = score(&wrong);
        for figure in [
            "false alarms",
            "single effects named first",
            "single effects named,",
            "pairs: both",
            "outside the table: unexplained",
            "free run after ≤",
        ] {
            assert_eq!(passed(&score_wrong, figure), Some(false), "{figure}");
        }
        assert!(score_wrong.misses.iter().any(|m| m.said.contains("refused")));
    }
}
