//! What the cases of each command came to.

use std::collections::BTreeMap;
use std::fmt;

use super::process::Outcome;

#[derive(Debug, Default)]
struct Line {
    cases: usize,
    accepted: usize,
    refused: usize,
    failures: usize,
    slowest: f64,
    memory: u64,
}

/// The counts by command.
#[derive(Debug, Default)]
pub struct Summary(BTreeMap<String, Line>);

impl Summary {
    /// Counts a case.
    pub fn add(&mut self, command: &str, outcome: &Outcome, failed: bool) {
        let line = self.0.entry(command.to_string()).or_default();
        line.cases += 1;
        match (failed, outcome.code) {
            (true, _) => line.failures += 1,
            (_, Some(0)) => line.accepted += 1,
            _ => line.refused += 1,
        }
        line.slowest = line.slowest.max(outcome.seconds);
        line.memory = line.memory.max(outcome.memory);
    }

    /// Cases that failed.
    pub fn failures(&self) -> usize {
        self.0.values().map(|line| line.failures).sum()
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "command        cases  accepted  refused  failures  slowest s  memory MB")?;
        for (name, line) in &self.0 {
            writeln!(
                f,
                "{name:<12} {:>7} {:>9} {:>8} {:>9} {:>10.2} {:>10}",
                line.cases,
                line.accepted,
                line.refused,
                line.failures,
                line.slowest,
                line.memory >> 20
            )?;
        }
        Ok(())
    }
}
