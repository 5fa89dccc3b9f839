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
        case(Group::Pair, vec![concealed("cogging", 900.0); 2], &said("explained", &[("cogging", &[])]), 0.9),
        case(Group::Outside, vec![concealed("ooc_dead_zone", 900.0)], "", 50.0),
    ];
    let score_wrong = score(&wrong);
    for figure in [
        "false alarms",
        "single effects named first",
        "single effects named,",
        "pairs: both",
        "outside the table: unexplained, or described without a name",
        "free run after ≤",
    ] {
        assert_eq!(passed(&score_wrong, figure), Some(false), "{figure}");
    }
    assert!(score_wrong.misses.iter().any(|m| m.said.contains("refused")));
}
