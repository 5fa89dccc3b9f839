//! What was checked and what was found, for people and for machines.

use serde::Serialize;

use super::external::ToolReport;
use super::sweep::SweepReport;

/// The result of all checks that were made.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Report {
    /// Why certificate and files do not belong together; empty where they do.
    pub certificate: Vec<String>,
    /// The sweeps.
    pub sweeps: Vec<SweepReport>,
    /// Routines whose languages give different outputs.
    pub different: Vec<String>,
    /// What other tools said.
    pub tools: Vec<ToolReport>,
}

impl Report {
    /// Notes routines whose outputs are not the same in every language.
    pub fn compare_digests(&mut self) {
        for (i, a) in self.sweeps.iter().enumerate() {
            let other = self.sweeps[..i].iter().find(|b| b.routine == a.routine && b.inputs == a.inputs);
            if let Some(b) = other.filter(|b| b.digest != a.digest) {
                self.different.push(format!(
                    "{}: {} and {} give different outputs, digests {} and {}",
                    a.routine, b.language, a.language, b.digest, a.digest
                ));
            }
        }
    }

    /// Whether every check that was made holds.
    pub fn holds(&self) -> bool {
        self.certificate.is_empty()
            && self.different.is_empty()
            && self.sweeps.iter().all(|s| s.violations.is_empty())
            && self.tools.iter().all(|t| t.holds)
    }

    /// The report as text.
    pub fn text(&self) -> String {
        let mut lines = Vec::new();
        if self.certificate.is_empty() {
            lines.push("certificate: recomputed, the same; files: as generated".to_string());
        }
        lines.extend(self.certificate.iter().map(|what| format!("REFUSED {what}")));
        for s in &self.sweeps {
            let how = if s.sanitized { ", undefined behaviour watched for" } else { "" };
            lines.push(format!("{} in {}{how}: {} inputs", s.routine, s.language, s.inputs));
            let exhaustive = if s.exhaustive { "exhaustive" } else { "NOT exhaustive" };
            lines.push(format!("  {exhaustive}: {}", s.covered));
            lines.push(format!(
                "  worst error {:.4e} {} ({:.3} LSB) at {}",
                s.worst_error, s.unit, s.worst_error_lsb, s.worst_input
            ));
            lines.push(format!(
                "  bound {:.4e} {}, {:.3} times the worst error; the reference itself is known to {:.1e}",
                s.bound, s.unit, s.margin, s.reference_error
            ));
            let interpreted = if s.as_interpreted { ", as the proved program gives on a subset" } else { "" };
            lines.push(format!("  digest {}{interpreted}", s.digest));
            lines.extend(s.violations.iter().map(|what| format!("  VIOLATED {what}")));
        }
        lines.extend(self.different.iter().map(|what| format!("DIFFERENT {what}")));
        for t in &self.tools {
            let mark = if t.holds { "" } else { "FAILED " };
            lines.push(format!("{mark}{} {}: {}", t.check, t.subject, t.finding));
        }
        let verdict = if self.holds() { "every check that was made holds" } else { "NOT verified" };
        lines.push(verdict.into());
        lines.join("\n") + "\n"
    }
}
