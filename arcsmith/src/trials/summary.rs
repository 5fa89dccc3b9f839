//! The summary for the terminal, or as JSON.

use std::path::Path;

use indicatif::ProgressBar;
use serde_json::{Value, json};
use trials::score::{Figure, Miss, reached};

use crate::terminal::{Common, FIGURE, WARNING, say, say_json};

/// Prints every result as it comes, above the progress bar; as JSON, all of them at the end.
pub struct Summary {
    common: Common,
    bar: ProgressBar,
    collected: Value,
}

impl Summary {
    /// Nothing was measured yet.
    pub fn new(common: Common, bar: ProgressBar) -> Self {
        Self { common, bar, collected: json!({"sets": [], "skipped": []}) }
    }

    /// The truth is sealed, before anything is diagnosed.
    pub fn sealed(&mut self, hash: &str, count: usize) {
        self.collected["recordings"] = json!(count);
        self.collected["sealed"] = json!(hash);
        self.say(&format!("{count} recordings; the truth is sealed: SHA-256 {hash}"));
    }

    /// The figures of the campaign; whether all are reached.
    pub fn campaign(&mut self, figures: &[Figure], misses: usize, out: &Path) -> bool {
        self.collected["figures"] = json!(figures);
        self.collected["misses"] = json!(misses);
        self.collected["written"] = json!(out.display().to_string());
        let out = out.display();
        self.say(&format!("{}{misses} answers that were not right are listed in {out}", styled(figures)));
        reached(figures)
    }

    /// The figures of other recordings, and what was not right; whether all are reached.
    pub fn set(&mut self, title: &str, figures: &[Figure], misses: &[Miss]) -> bool {
        let mut text = format!("\n{title}\n{}", styled(figures));
        for miss in misses {
            text += &format!("{}: {}: {} → {}\n", miss.recording, miss.figure, miss.concealed, miss.said);
        }
        self.push("sets", json!({"title": title, "figures": figures, "misses": misses}));
        self.say(text.trim_end_matches('\n'));
        reached(figures)
    }

    /// Something could not be measured here.
    pub fn skipped(&mut self, why: &str) {
        self.push("skipped", json!(why));
        self.say(&format!("\n{why}"));
    }

    /// Nothing more comes.
    pub fn end(mut self, reached: bool) {
        if self.common.json {
            self.collected["reached"] = json!(reached);
            say_json(&format!("{:#}", self.collected));
        }
    }

    fn push(&mut self, list: &str, value: Value) {
        if let Some(list) = self.collected[list].as_array_mut() {
            list.push(value);
        }
    }

    fn say(&self, text: &str) {
        if !self.common.json && !self.common.quiet {
            self.bar.suspend(|| say(text));
        }
    }
}

/// The table in colours.
fn styled(figures: &[Figure]) -> String {
    let colour = |line: &str| match line {
        line if line.starts_with("pass") => format!("{FIGURE}pass{FIGURE:#}{}\n", &line[4..]),
        line if line.starts_with("FAIL") => format!("{WARNING}FAIL{WARNING:#}{}\n", &line[4..]),
        line => format!("{line}\n"),
    };
    table(figures).lines().map(colour).collect()
}

/// The figures as a table, one to a line.
fn table(figures: &[Figure]) -> String {
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

fn word(passed: Option<bool>) -> &'static str {
    match passed {
        Some(true) => "pass",
        Some(false) => "FAIL",
        None => "–",
    }
}
