//! The two tables of a fleet as columns: `units`, a row for every unit, and `parameters`, a row for every parameter of every
//! effect in every unit. Files and Arrow are written from this one form.

use diagnosis::fleet::{Forced, Test};

use super::answer::{Answer, Estimated, Found, Unit};

/// What stands in every row: this program.
pub const PROGRAM: &str = concat!("arcsmith ", env!("CARGO_PKG_VERSION"));

/// The cells of a column, one for each row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Text, or nothing.
    Text(Vec<Option<String>>),
    /// A number, or nothing.
    Number(Vec<Option<f64>>),
    /// A list of texts.
    Texts(Vec<Vec<String>>),
    /// A list of numbers.
    Numbers(Vec<Vec<f64>>),
}

/// A column with its name.
pub type Column = (&'static str, Cells);

/// The table `units` of some answers; `options` is the hash of what all were asked.
pub fn units(answers: &[Answer], options: &str) -> Vec<Column> {
    let text = |of: &dyn Fn(&Answer) -> Option<String>| Cells::Text(answers.iter().map(of).collect());
    let number = |of: &dyn Fn(&Answer) -> Option<f64>| Cells::Number(answers.iter().map(of).collect());
    let texts = |of: &dyn Fn(&Found) -> Vec<String>| {
        Cells::Texts(answers.iter().map(|answer| answer.found.as_ref().map(of).unwrap_or_default()).collect())
    };
    let numbers = |of: fn(&Forced) -> &Vec<f64>| {
        let one = |answer: &Answer| answer.found.as_ref().map(|f| of(&f.forced).clone()).unwrap_or_default();
        Cells::Numbers(answers.iter().map(one).collect())
    };
    let score = |of: fn(&diagnosis::Fit) -> diagnosis::Score| {
        number(&|a: &Answer| {
            let score = of(&a.found.as_ref().ok()?.diagnosis.fit);
            Some(score.held_out_rms.unwrap_or(score.train_rms))
        })
    };
    vec![
        ("unit", text(&|a| Some(a.unit.name.clone()))),
        ("file", text(&|a| Some(a.unit.file.clone()))),
        ("sha256", text(&|a| a.sha256.clone())),
        ("lot", text(&|a| a.unit.lot.clone())),
        ("time", number(&|a| a.unit.time)),
        ("rows", number(&|a| Some(found(a)?.rows as f64))),
        ("verdict", text(&|a| Some(found(a)?.diagnosis.verdict.word().into()))),
        ("effects", texts(&|f| f.diagnosis.effects.iter().map(|e| e.id.clone()).collect())),
        ("formulae", texts(&|f| f.diagnosis.effects.iter().map(|e| e.formula.clone()).collect())),
        ("unit_of_measure", text(&|a| Some(found(a)?.diagnosis.fit.unit.clone()))),
        ("rms_before", score(|fit| fit.before.clone())),
        ("rms_after", score(|fit| fit.after.clone())),
        ("held_out_by", text(&|a| Some(found(a)?.diagnosis.fit.held_out_by.clone()))),
        ("noise", number(&|a| Some(found(a)?.diagnosis.noise_floor.value))),
        ("judged", texts(&|f| f.diagnosis.judged.clone())),
        ("withheld", text(&|a| found(a)?.diagnosis.withheld.clone())),
        ("error", text(&|a| a.found.as_ref().err().cloned())),
        ("coefficients", text(&|a| found(a)?.coefficients.clone())),
        ("tests", texts(&|f| f.forced.tests.iter().map(written).collect())),
        ("terms", texts(&|f| f.forced.terms.clone())),
        ("scores", numbers(|forced| &forced.scores)),
        ("information", numbers(|forced| &forced.information)),
        ("program", text(&|_| Some(PROGRAM.into()))),
        ("options", text(&|_| Some(options.into()))),
    ]
}

/// The table `parameters` of some answers.
pub fn parameters(answers: &[Answer]) -> Vec<Column> {
    let rows: Vec<(&Unit, Estimated)> = (answers.iter())
        .filter_map(|answer| Some((&answer.unit, answer.found.as_ref().ok()?)))
        .flat_map(|(unit, found)| found.estimated().into_iter().map(move |one| (unit, one)))
        .collect();
    let text = |of: &dyn Fn(&Estimated) -> &str| {
        Cells::Text(rows.iter().map(|(_, one)| Some(of(one).to_string())).collect())
    };
    let number = |of: &dyn Fn(&Estimated) -> f64| {
        Cells::Number(rows.iter().map(|(_, one)| Some(of(one)).filter(|value| value.is_finite())).collect())
    };
    vec![
        ("unit", Cells::Text(rows.iter().map(|(unit, _)| Some(unit.name.clone())).collect())),
        ("kind", text(&|one| if one.named { NAMED } else { FORCED })),
        ("effect", text(&|one| &one.effect)),
        ("parameter", text(&|one| &one.parameter)),
        ("at", text(&|one| &one.at)),
        ("unit_of_measure", text(&|one| &one.unit_of_measure)),
        ("value", number(&|one| one.value)),
        ("low", number(&|one| one.ci95[0])),
        ("high", number(&|one| one.ci95[1])),
        ("standard_error", number(&|one| one.error)),
    ]
}

/// The kind of a parameter of an effect that the unit's diagnosis names.
pub const NAMED: &str = "named";
/// That of one that is estimated whether the effect is named or not.
pub const FORCED: &str = "forced";

fn found(answer: &Answer) -> Option<&Found> {
    answer.found.as_ref().ok()
}

/// A test as it stands in a list.
fn written(test: &Test) -> String {
    [&test.effect, &test.at, &test.parameter, &test.unit].map(String::as_str).join("|")
}

/// A test that stands in a list.
pub fn test(written: &str) -> Option<Test> {
    let mut parts = written.splitn(4, '|').map(str::to_string);
    let mut next = || parts.next();
    Some(Test { effect: next()?, at: next()?, parameter: next()?, unit: next()? })
}
