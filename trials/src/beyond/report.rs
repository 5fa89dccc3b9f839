//! The report: JSON with every recording, and its tables in Markdown.

use super::campaign::Campaign;
use super::score::{Line, NullLine, Row, Score, score};
use crate::report::{Page, Report};
use crate::score::Figure;
use crate::workspace::Outcome;

impl Report<Score> {
    /// Scores a campaign beyond the catalogue.
    pub fn of_beyond(campaign: &Campaign, outcome: &Outcome<Row>) -> Self {
        let counts = &campaign.counts;
        let mut command = format!(
            "trials beyond --trials {} --nulls {} --seed {}",
            counts.trials, counts.nulls, campaign.seed
        );
        if counts.motion > 0 {
            command += &format!(" --motion {}", counts.motion);
        }
        if counts.left_out > 0 {
            command += &format!(" --leave-out {}", counts.left_out);
        }
        command.extend(counts.kinds.iter().map(|id| format!(" --kind {id}")));
        Self::of(command, outcome, score)
    }
}

impl Page for Report<Score> {
    const FILE: &str = "report.md";

    /// The figures and tables in Markdown.
    fn page(&self) -> String {
        let mut text = format!("```sh no-run: minutes\narcsmith {}\n```\n\n", self.command);
        text += "| figure | wanted | measured |\n|---|---|---|\n";
        for Figure { figure, wanted, measured, passed } in &self.score.figures {
            let missed = if *passed == Some(false) { " (missed)" } else { "" };
            text += &format!("| {figure} | {wanted} | {measured}{missed} |\n");
        }
        for (title, lines) in [
            ("kind", &self.score.kinds),
            ("kind in motion", &self.score.motion),
            ("left out of the catalogue", &self.score.left_out),
            ("noise", &self.score.families),
            ("condition", &self.score.conditions),
            ("ρ", &self.score.strengths),
        ] {
            if !lines.is_empty() {
                text += &table(title, lines);
            }
        }
        if !self.score.nulls.is_empty() {
            text += &nulls(&self.score.nulls);
        }
        text
    }
}

fn table(title: &str, lines: &[Line]) -> String {
    let mut text = format!(
        "\n| {title} | recordings | found | located | catalogued name alone | of it, gain lost | gain counted | pooled | \
         median | ≥ 90 % | made worse |\n|---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    let percent = |part: Option<f64>| part.map_or("–".to_owned(), |part| format!("{:.0} %", 100.0 * part));
    for line in lines {
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
            line.what,
            line.recordings,
            line.found,
            line.located,
            line.named_alone,
            line.named_and_lost,
            line.counted,
            percent(line.pooled),
            percent(line.median),
            line.realised,
            line.harmed
        );
    }
    text
}

fn nulls(lines: &[NullLine]) -> String {
    let mut text =
        "\n| nothing concealed, noise | recordings | alarms | named | terms for firmware | made worse |\n\
                    |---|---|---|---|---|---|\n"
            .to_owned();
    for NullLine { family, recordings, alarms, named, terms, harmed } in lines {
        text += &format!("| {family} | {recordings} | {alarms} | {named} | {terms} | {harmed} |\n");
    }
    text
}
