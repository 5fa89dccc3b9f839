//! The scorer on a small set of made-up answers whose score is known.

use super::*;
use crate::answer::{Fit, Location, Named, Parameter, Score as Residual, Verdict};
use crate::truth::{Concealed, Group};

fn said(verdict: Verdict, names: &[(&str, &[&str])], variable: &str) -> Answer {
    Answer {
        verdict,
        locations: match variable {
            "" => Vec::new(),
            _ => vec![Location { variable: variable.to_owned(), times: None }],
        },
        effects: names
            .iter()
            .map(|(id, alternatives)| Named {
                id: (*id).to_owned(),
                parameters: Vec::new(),
                alternatives: alternatives.iter().map(|a| (*a).to_owned()).collect(),
            })
            .collect(),
        fit: Fit {
            before: Residual { held_out_rms: Some(1.0) },
            after: Residual { held_out_rms: Some(0.5) },
            gain: None,
        },
        unidentifiable: Vec::new(),
        next_experiment: None,
    }
}

fn case(group: Group, effects: &[(&str, f64)], answer: Answer) -> Case {
    let effects = effects
        .iter()
        .map(|(id, rho)| Concealed {
            id: (*id).to_owned(),
            parameters: std::collections::BTreeMap::new(),
            rho: *rho,
            depends_on: crate::draw::depends_on(id),
            imitation: None,
            step_window_s: None,
        })
        .collect();
    let truth = Truth {
        recording: "r.csv".to_owned(),
        group,
        family: "white".to_owned(),
        schedule: "fine".to_owned(),
        temperature: "chamber".to_owned(),
        noise_arcsec: 0.5,
        effects,
        fresh_is_fair: true,
    };
    Case {
        truth,
        answer: Some(answer),
        fresh: None,
        without: None,
        left_by_names: [None; 2],
        benchmark: None,
    }
}

/// One case of nearly every kind.
pub(crate) fn some_cases() -> Vec<Case> {
    use Verdict::{Consistent, Explained, Unexplained};
    let quiet = || said(Consistent, &[], "");
    let mut cases: Vec<Case> = (0..99).map(|_| case(Group::Null, &[], quiet())).collect();
    cases.push(case(Group::Null, &[], said(Explained, &[("time_drift", &[])], "t_s")));
    for i in 0..40 {
        let rho = 0.2 * f64::from(i);
        let heard = if rho > 4.0 || i % 7 == 0 { said(Unexplained, &[], "t_s") } else { quiet() };
        cases.push(case(Group::Weak, &[("time_drift", rho)], heard));
    }
    let zero = [("thermal_zero_drift", 10.0)];
    cases.push(case(Group::Strong, &zero, said(Explained, &[("thermal_zero_drift", &[])], "temperature_c")));
    cases.push(case(
        Group::Strong,
        &zero,
        said(Explained, &[("thermal_lag", &["thermal_zero_drift"])], "t_s"),
    ));
    cases.push(case(Group::Strong, &zero, said(Explained, &[("time_drift", &[])], "t_s")));
    let two = [("thermal_zero_drift", 10.0), ("backlash", 9.0)];
    let both: &[(&str, &[&str])] = &[("backlash", &[]), ("thermal_zero_drift", &[])];
    cases.push(case(Group::Pair, &two, said(Explained, both, "direction")));
    cases.push(case(Group::Pair, &two, said(Explained, &both[..1], "direction")));
    let outside = [("ooc_sway", 12.0)];
    cases.push(case(Group::Outside, &outside, said(Unexplained, &[], "t_s")));
    cases.push(case(Group::Outside, &outside, said(Unexplained, &[], "coil_a")));
    cases.push(case(Group::Outside, &outside, said(Explained, &[("mount_step", &[])], "t_s")));
    cases
}

fn figure<'a>(score: &'a Score, begins: &str) -> &'a Figure {
    score.figures.iter().find(|f| f.figure.starts_with(begins)).unwrap()
}

#[test]
fn shares_are_those_of_the_made_up_answers() {
    let score = score(&some_cases());
    assert_eq!(score.false_alarms[0].share, Share { hits: 1, of: 100 });
    assert!(figure(&score, "false alarms, white").measured.starts_with("1.00 % (1/100)"));
    // One in a hundred neither shows nor refutes 1 %.
    assert_eq!(figure(&score, "false alarms, white").passed, None);
    assert!(figure(&score, "right name first").measured.contains("(1/3;"));
    assert!(figure(&score, "named or among").measured.contains("(2/3;"));
    assert!(figure(&score, "right observable").measured.contains("(1/3;"));
    assert!(figure(&score, "two effects").measured.contains("(1/2;"));
    assert!(figure(&score, "outside the table, ρ").measured.contains("(1/3;"));
    assert!(figure(&score, "outside the table: a wrong").measured.contains("(1/3;"));
    assert_eq!(figure(&score, "three effects").passed, None);
}

#[test]
fn false_alarms_are_shown_by_many_nulls_and_refuted_by_few() {
    let nulls = |alarms: usize, of: usize| {
        let answer = |i| match i < alarms {
            true => said(Verdict::Unexplained, &[], "t_s"),
            false => said(Verdict::Consistent, &[], ""),
        };
        let cases: Vec<Case> = (0..of).map(|i| case(Group::Null, &[], answer(i))).collect();
        figure(&score(&cases), "false alarms, white").passed
    };
    assert_eq!(nulls(20, 2000), Some(true));
    // 21 of 2000 is more than 1 %.
    assert_eq!(nulls(21, 2000), Some(false));
    assert_eq!(nulls(0, 100), None);
    assert_eq!(nulls(10, 100), Some(false));
}

#[test]
fn the_confusion_matrix_tells_alternatives_from_other_names() {
    let confusion = score(&some_cases()).confusion;
    let (id, counts) = &confusion.rows[0];
    assert_eq!(id, "thermal_zero_drift");
    let of = |column: &str| counts[confusion.columns.iter().position(|c| c == column).unwrap()];
    assert_eq!((of("thermal_zero_drift"), of("alternatives"), of("time_drift")), (1, 1, 1));
}

#[test]
fn every_miss_is_listed() {
    let score = score(&some_cases());
    let of = |figure: &str| score.misses.iter().filter(|m| m.figure == figure).count();
    assert_eq!(of("false alarm"), 1);
    assert_eq!(of("right name first"), 2);
    assert_eq!(of("named or alternative"), 1);
    assert_eq!(of("set of two"), 1);
    assert_eq!(of("outside the table"), 2);
}

#[test]
fn a_refused_recording_is_no_right_answer() {
    let mut cases = some_cases();
    cases.iter_mut().for_each(|c| c.answer = None);
    let score = score(&cases);
    assert!(figure(&score, "false alarms, white").measured.starts_with("100.00 %"));
    assert!(figure(&score, "right name first").measured.contains("(0/3;"));
}

#[test]
fn intervals_that_miss_too_often_are_inconsistent() {
    let parameter = |value: f64, half: f64| Parameter {
        name: "rate_arcsec_per_h".to_owned(),
        value,
        ci95: [value - half, value + half],
    };
    let cases: Vec<Case> = (0..200)
        .map(|i| {
            let mut answer = said(Verdict::Explained, &[("time_drift", &[])], "t_s");
            // Half of the intervals are too short.
            answer.effects[0].parameters = vec![parameter(2.0, if i % 2 == 0 { 2.0 } else { 0.5 })];
            let mut case = case(Group::Strong, &[("time_drift", 10.0)], answer);
            case.truth.effects[0].parameters.insert("rate_arcsec_per_h".to_owned(), 1.0);
            case
        })
        .collect();
    let score = score(&cases);
    assert_eq!(score.coverage[0].share, Share { hits: 100, of: 200 });
    assert!(!score.coverage[0].consistent);
    assert_eq!(figure(&score, "coverage").passed, Some(false));
}

#[test]
fn a_step_counts_to_within_one_row() {
    for (time_s, right) in [(1.0, false), (1.5, true), (4.0, true), (4.5, false)] {
        let mut answer = said(Verdict::Explained, &[("mount_step", &[])], "t_s");
        answer.effects[0].parameters =
            vec![Parameter { name: "time_s".to_owned(), value: time_s, ci95: [time_s, time_s] }];
        let mut one = case(Group::Step, &[("mount_step", 20.0)], answer);
        // Rows at 0, 1, 2, 3, 4, 5; the step lies between 2 and 3.
        one.truth.effects[0].step_window_s = Some([1.0, 4.0]);
        one.truth.effects[0].parameters.insert("step_arcsec".to_owned(), 2.0);
        let wanted = u64::from(right);
        let measured = figure(&score(&[one]), "time of a step").measured.clone();
        assert!(measured.contains(&format!("({wanted}/1;")), "{time_s}: {measured}");
    }
}

#[test]
fn coverage_by_schedule_is_refuted_where_it_is_beyond_chance() {
    let of = |held: usize, of: usize| -> Score {
        let cases: Vec<Case> = (0..of)
            .map(|i| {
                let mut answer = said(Verdict::Explained, &[("time_drift", &[])], "t_s");
                let ci95 = if i < held { [0.0, 3.0] } else { [1.5, 3.0] };
                let name = "rate_arcsec_per_h".to_owned();
                answer.effects[0].parameters = vec![Parameter { name, value: 2.0, ci95 }];
                let mut case = case(Group::Interval, &[("time_drift", 10.0)], answer);
                case.truth.effects[0].parameters.insert("rate_arcsec_per_h".to_owned(), 1.0);
                case
            })
            .collect();
        score(&cases)
    };
    let scored = of(340, 400);
    let cell = &scored.cells[0];
    assert_eq!((cell.schedule.as_str(), cell.covered), ("fine", Share { hits: 340, of: 400 }));
    assert_eq!((cell.above, cell.own), (60, Share { hits: 400, of: 400 }));
    assert!(cell.refuted);
    assert_eq!(figure(&scored, "the same beyond chance").passed, Some(false));
    // 91 % of 100 may be chance; what is drawn for the intervals is no part of the pooled figure.
    let scored = of(91, 100);
    assert!(!scored.cells[0].refuted);
    assert_eq!(figure(&scored, "coverage of the 95 % intervals, pooled").passed, None);
}

#[test]
fn a_second_recording_that_comes_out_worse_is_counted_and_listed() {
    let fresh = |ratio: f64| Fresh {
        answer_arcsec: ratio,
        base_arcsec: 1.0,
        fit_arcsec: Some(1.0),
        informed_arcsec: 0.5,
        fully_informed_arcsec: None,
        inside_ratio: 1.0,
        extrapolated: 0,
        rows: 210,
    };
    let cases: Vec<Case> = [0.5, 1.02, 1.05, 1.2]
        .map(|ratio| {
            let answer = said(Verdict::Explained, &[("time_drift", &[])], "t_s");
            Case { fresh: Some(fresh(ratio)), ..case(Group::Twice, &[("time_drift", 3.0)], answer) }
        })
        .into();
    let score = score(&cases);
    assert_eq!(score.harm.worse, Share { hits: 2, of: 4 });
    assert_eq!(score.harm.much_worse, Share { hits: 1, of: 4 });
    assert_eq!(figure(&score, "second recordings more than 3 %").passed, Some(false));
    assert_eq!(score.misses.iter().filter(|m| m.figure == "second recording").count(), 2);
    // They are drawn for this figure alone.
    assert_eq!(score.worth.compared, 0);
}
