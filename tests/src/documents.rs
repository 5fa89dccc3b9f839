//! The commands that the documentation shows: fenced blocks labelled `sh` or `console`, and what follows the label.
//!
//! - ```` ```sh ```` is a script; every command of it has to succeed.
//! - ```` ```console ```` shows commands behind `$ ` and below each what it prints; every line that is shown has to
//!   be printed, in that order. `…` stands for anything.
//! - ```` ```sh no-run: it takes an hour ```` is not run, for the reason given; that its programs have the commands
//!   and options that it names is checked nevertheless.
//!
//! Blocks of one document run one after the other in one folder. One that names `$ARCSMITH_RECORDINGS` is skipped
//! where that is not set.

use std::path::{Path, PathBuf};

/// A fenced block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// The label.
    pub label: String,
    /// What follows the label.
    pub further: String,
    /// What stands between the fences.
    pub text: String,
}

/// A command and what is shown of its output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The command.
    pub command: String,
    /// The lines shown.
    pub shown: Vec<String>,
}

impl Block {
    /// Whether it shows commands.
    pub fn is_run(&self) -> bool {
        matches!(self.label.as_str(), "sh" | "console")
    }

    /// Why it is not run.
    pub fn not_run(&self) -> Option<&str> {
        self.further.strip_prefix("no-run").map(|reason| reason.trim_start_matches(':').trim())
    }

    /// The steps: of a script one, of a console as many as there are prompts.
    ///
    /// # Panics
    /// Where a console begins without a prompt.
    pub fn steps(&self) -> Vec<Step> {
        if self.label == "sh" {
            return vec![Step { command: self.text.clone(), shown: Vec::new() }];
        }
        let mut steps: Vec<Step> = Vec::new();
        let mut goes_on = false;
        for line in self.text.lines() {
            let last = steps.last_mut();
            if let Some(command) = line.strip_prefix("$ ") {
                steps.push(Step { command: command.to_string(), shown: Vec::new() });
            } else if let Some(step) = last {
                match goes_on {
                    true => step.command += &format!("\n{line}"),
                    false => step.shown.push(line.to_string()),
                }
            } else {
                panic!("line {}: a console begins with a command behind `$ `", self.line);
            }
            goes_on = line.ends_with('\\') && (goes_on || line.starts_with("$ "));
        }
        steps
    }

    /// The commands one by one, continued lines joined.
    pub fn commands(&self) -> Vec<String> {
        let text: String = self.steps().iter().map(|step| step.command.clone() + "\n").collect();
        let joined = text.replace("\\\n", " ");
        joined
            .lines()
            .map(str::trim)
            .filter(|l| !l.is_empty() && !l.starts_with('#'))
            .map(str::to_string)
            .collect()
    }
}

/// The fenced blocks of a text in Markdown.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let mut open = false;
    let mut indented = 0;
    for (index, line) in text.lines().enumerate() {
        match line.trim_start().strip_prefix("```") {
            Some(_) if open => open = false,
            Some(label) => {
                // In a list the block is indented as its fence is.
                indented = line.len() - line.trim_start().len();
                let (label, further) = label.split_once(' ').unwrap_or((label, ""));
                let (label, further) = (label.to_string(), further.trim().to_string());
                found.push(Block { line: index + 1, label, further, text: String::new() });
                open = true;
            }
            None if open => {
                if let Some(block) = found.last_mut() {
                    let blanks = line.len() - line.trim_start().len();
                    block.text += &line[indented.min(blanks)..];
                    block.text += "\n";
                }
            }
            None => {}
        }
    }
    found
}

/// The links of a text in Markdown with their lines; those in fenced blocks are none.
pub fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut open = false;
    for (index, line) in text.lines().enumerate() {
        open ^= line.trim_start().starts_with("```");
        let targets = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
        found.extend(targets.filter(|_| !open).map(|(target, _)| (index + 1, target.to_string())));
    }
    found
}

/// The anchors of a page's headings: letters and digits in lower case, a hyphen for every space.
pub fn anchors(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for heading in text
        .lines()
        .filter_map(|line| line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#')))
    {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let anchor = kept.collect::<String>().to_lowercase().replace(' ', "-");
        let before = found.iter().filter(|other| **other == anchor).count();
        found.push(if before == 0 { anchor } else { format!("{anchor}-{before}") });
    }
    found
}

/// README.md, CONTRIBUTING.md and everything below docs that is Markdown, sorted.
///
/// # Panics
/// Where the project cannot be read.
pub fn documents(root: &Path) -> Vec<PathBuf> {
    let mut found = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    let mut pending = vec![root.join("docs")];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Whether the lines shown are printed, in that order; `Err` names the first that is not. Spaces count as one.
pub fn printed(shown: &[String], output: &str) -> Result<(), String> {
    let plain = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut lines = output.lines().map(plain);
    for wanted in shown.iter().map(|line| plain(line)).filter(|line| !line.is_empty() && line != "…") {
        if !lines.any(|line| matches(&wanted, &line)) {
            return Err(wanted);
        }
    }
    Ok(())
}

/// Whether a line is as shown, `…` standing for anything.
fn matches(shown: &str, line: &str) -> bool {
    let mut parts = shown.split('…');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = line.strip_prefix(first) else { return false };
    let parts: Vec<&str> = parts.collect();
    let Some((last, between)) = parts.split_last() else { return rest.is_empty() };
    for part in between {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_their_steps_are_told_apart() {
        let text = "a\n```console\n$ one \\\n  two\nout\n$ three\n```\n```sh no-run: long\nx # y\n\n# z\nb \\\n c\n```\n```toml\nk = 1\n```\n";
        let found = blocks(text);
        assert_eq!(
            found.iter().map(|b| (b.line, b.label.as_str())).collect::<Vec<_>>(),
            [(2, "console"), (8, "sh"), (15, "toml")]
        );
        let steps = found[0].steps();
        assert_eq!(
            (steps[0].command.as_str(), &steps[0].shown[..]),
            ("one \\\n  two", &["out".to_string()][..])
        );
        assert_eq!((steps[1].command.as_str(), steps[1].shown.len()), ("three", 0));
        assert_eq!((found[0].not_run(), found[1].not_run()), (None, Some("long")));
        assert_eq!(found[1].commands(), ["x # y", "b   c"]);
        assert!(!found[2].is_run());
        let listed = blocks("1. a\n\n   ```console\n   $ b \\\n       c\n   d\n   ```\n");
        assert_eq!(listed[0].text, "$ b \\\n    c\nd\n");
    }

    #[test]
    fn links_and_headings_are_found() {
        let text = "# A `b` c, d\n[x](y.md#z) and [u](v)\n```\n[no](link)\n```\n## A b c d\n";
        assert_eq!(links(text), [(2, "y.md#z".to_string()), (2, "v".to_string())]);
        assert_eq!(anchors(text), ["a-b-c-d", "a-b-c-d-1"]);
    }

    #[test]
    fn lines_that_are_shown_must_be_printed_in_their_order() {
        let shown = |lines: &[&str]| lines.iter().map(|l| l.to_string()).collect::<Vec<_>>();
        let output = "order   9 of 15\nbefore rms 400\nafter rms 0.5\n";
        assert_eq!(printed(&shown(&["order 9 of 15", "after …"]), output), Ok(()));
        assert_eq!(printed(&shown(&["order … 15"]), output), Ok(()));
        assert_eq!(printed(&shown(&["after …", "before …"]), output), Err("before …".to_string()));
        assert_eq!(printed(&shown(&["order 9"]), output), Err("order 9".to_string()));
        assert_eq!(printed(&shown(&["… rms … 4"]), output), Err("… rms … 4".to_string()));
    }
}
