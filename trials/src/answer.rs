//! What `diagnose` said of a recording: the part of its JSON that is scored.

use std::path::Path;

use crate::error::CampaignError;

use serde::Deserialize;

/// The verdict as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing beyond the noise.
    Consistent,
    /// Named effects leave noise.
    Explained,
    /// What was found leaves noise, and some of it is a form without a name.
    Described,
    /// Named effects, and structure is left.
    PartlyExplained,
    /// Structure without a name.
    Unexplained,
}

#[derive(Debug, Clone, Deserialize)]
pub struct Answer {
    pub verdict: Verdict,
    /// The strongest first.
    pub locations: Vec<Location>,
    /// The strongest first.
    pub effects: Vec<Named>,
    pub fit: Fit,
    /// What the recording does not determine, in sentences.
    #[serde(default)]
    pub unidentifiable: Vec<String>,
    pub next_experiment: Option<String>,
}

/// Where the mismatch lives.
#[derive(Debug, Clone, Deserialize)]
pub struct Location {
    pub variable: String,
    /// What multiplies it.
    #[serde(default)]
    pub times: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
pub struct Named {
    pub id: String,
    pub parameters: Vec<Parameter>,
    /// Ids that the recording cannot tell from it.
    pub alternatives: Vec<String>,
}

#[derive(Debug, Clone, Deserialize)]
pub struct Parameter {
    pub name: String,
    pub value: f64,
    pub ci95: [f64; 2],
}

/// The proof on held-out passes.
#[derive(Debug, Clone, Deserialize)]
pub struct Fit {
    /// The base model alone.
    pub before: Score,
    pub after: Score,
    #[serde(default)]
    pub gain: Option<Gain>,
}

#[derive(Debug, Clone, Deserialize)]
pub struct Score {
    /// On held-out rows.
    pub held_out_rms: Option<f64>,
}

/// rms before less rms after, on held-out rows.
#[derive(Debug, Clone, Deserialize)]
pub struct Gain {
    /// Its paired 95 % interval.
    pub ci95: [f64; 2],
}

/// What is expected of a file.
const DIAGNOSIS: &str = "the diagnosis of a recording";

impl Answer {
    /// Reads the diagnosis at `path`.
    ///
    /// # Errors
    /// [`CampaignError`] where it is missing or of another form.
    pub fn read(path: &Path) -> Result<Self, CampaignError> {
        let text = std::fs::read_to_string(path).map_err(|e| CampaignError::Unreadable {
            path: path.to_owned(),
            reason: e.kind(),
            expected: DIAGNOSIS,
        })?;
        serde_json::from_str(&text).map_err(|reason| CampaignError::Form {
            path: path.to_owned(),
            reason,
            expected: DIAGNOSIS,
        })
    }

    /// Whether anything is reported.
    pub fn detects(&self) -> bool {
        self.verdict != Verdict::Consistent
    }

    /// Whether structure is reported and no effect of the catalogue named: at most forms without a name.
    pub fn names_nothing(&self) -> bool {
        self.detects() && self.effects.iter().all(|effect| effect.id.starts_with("empirical_"))
    }

    /// The effect that is named first.
    pub fn first(&self) -> Option<&str> {
        self.effects.first().map(|e| e.id.as_str())
    }

    /// The named ids, sorted.
    pub fn ids(&self) -> Vec<&str> {
        let mut ids: Vec<&str> = self.effects.iter().map(|e| e.id.as_str()).collect();
        ids.sort_unstable();
        ids
    }

    /// Whether an id is named or listed as an alternative of a named one.
    pub fn mentions(&self, id: &str) -> bool {
        self.effects.iter().any(|e| e.id == id || e.alternatives.iter().any(|a| a == id))
    }

    /// Whether the strongest location is on one of the variables.
    pub fn located_on(&self, variables: &[String]) -> bool {
        self.locations.first().is_some_and(|l| variables.contains(&l.variable))
    }

    /// In words, for the list of misses.
    pub fn sentence(&self) -> String {
        let verdict = match self.verdict {
            Verdict::Consistent => "consistent",
            Verdict::Explained => "explained",
            Verdict::Described => "described",
            Verdict::PartlyExplained => "partly explained",
            Verdict::Unexplained => "unexplained",
        };
        let mut text = verdict.to_owned();
        for (k, effect) in self.effects.iter().enumerate() {
            text += if k == 0 { ": " } else { " + " };
            text += &effect.id;
            if !effect.alternatives.is_empty() {
                text += &format!(" (or {})", effect.alternatives.join(", "));
            }
        }
        if let Some(location) = self.locations.first() {
            let times = location.times.as_ref().map_or(String::new(), |t| format!(" × {t}"));
            text += &format!(" · on {}{times}", location.variable);
        }
        text
    }
}
