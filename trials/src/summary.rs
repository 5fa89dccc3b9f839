//! The summary for the terminal.

use crate::score::Figure;

/// The figures as a table, one to a line.
pub fn table(figures: &[Figure]) -> String {
    let width =
        |text: fn(&Figure) -> &str| figures.iter().map(|f| text(f).chars().count()).max().unwrap_or(0);
    let (first, second) = (width(|f| &f.figure), width(|f| &f.wanted));
    let mut text = String::new();
    for figure in figures {
        text += &format!(
            "{:4}  {:first$}  {:second$}  {}\n",
            word(figure.passed),
            figure.figure,
            figure.wanted,
            figure.measured
        );
    }
    text
}

/// Whether every figure that has a wanted value and could be measured is reached.
pub fn reached(figures: &[Figure]) -> bool {
    figures.iter().all(|f| f.passed != Some(false))
}

fn word(passed: Option<bool>) -> &'static str {
    match passed {
        Some(true) => "pass",
        Some(false) => "FAIL",
        None => "–",
    }
}
