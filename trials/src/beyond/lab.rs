//! A recording as the programs are given it, and beside it what only the simulation knows.

use std::fmt::Write as _;

/// A recording.
#[derive(Debug, Clone, Default)]
pub struct Lab {
    /// The columns as they are written, by name.
    pub columns: Vec<(String, Vec<f64>)>,
    /// The reading that is to be corrected, in the unit of the result.
    pub measured: Vec<f64>,
    /// The name of the column that holds the reference, which is in the same unit.
    pub reference: &'static str,
    /// The reference without its noise.
    pub clean: Vec<f64>,
    /// What the concealed physics adds to the reading.
    pub effect: Vec<f64>,
    /// Standard deviation of the noise of the error, what lasts of it apart.
    pub noise: f64,
}

impl Lab {
    pub fn rows(&self) -> usize {
        self.measured.len()
    }

    /// A column; empty where it is not recorded.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.iter().find(|(other, _)| other == name).map_or(&[], |(_, values)| values)
    }

    /// Changes a column; nothing where it is not recorded.
    pub fn change(&mut self, name: &str, change: impl FnOnce(&mut [f64])) {
        if let Some((_, values)) = self.columns.iter_mut().find(|(other, _)| other == name) {
            change(values);
        }
    }

    /// The recorded error of the reading.
    pub fn error(&self) -> Vec<f64> {
        self.measured.iter().zip(self.column(self.reference)).map(|(m, r)| m - r).collect()
    }

    /// What stands in the rows whose reading another recording covers as well: beyond it no model promises anything.
    pub fn covered(&self, other: &Lab, values: &[f64]) -> Vec<f64> {
        let low = other.measured.iter().copied().fold(f64::INFINITY, f64::min);
        let high = other.measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let rows = self.measured.iter().zip(values);
        rows.filter(|(measured, _)| (low..=high).contains(*measured)).map(|(_, value)| *value).collect()
    }

    /// Leaves out rows.
    pub fn keep(&mut self, kept: &[bool]) {
        let own = [&mut self.measured, &mut self.clean, &mut self.effect];
        for values in self.columns.iter_mut().map(|(_, values)| values).chain(own) {
            let mut rows = kept.iter();
            values.retain(|_| rows.next().copied().unwrap_or(false));
        }
    }

    /// As CSV, with so many decimals.
    pub fn csv(&self, decimals: impl Fn(&str) -> usize) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (index, (name, values)) in self.columns.iter().enumerate() {
                let comma = if index > 0 { "," } else { "" };
                // Writing into memory cannot fail.
                let _ = write!(text, "{comma}{:.*}", decimals(name), values[row]);
            }
            text.push('\n');
        }
        text
    }
}
