//! What is stepped through, how often and how fast.

/// A calibration or verification protocol: passes over equidistant angles, forward and backward in turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// First and last commanded angle in degrees, first < last.
    pub range_deg: (f64, f64),
    /// Step between commanded angles in degrees; it divides the range.
    pub step_deg: f64,
    /// Number of passes; the first, third, … run forward (increasing angle), the others backward.
    pub passes: u32,
    /// Time from one reading to the next in seconds.
    pub dwell_s: f64,
    /// The time to settle varies by up to this much either way, in seconds.
    pub dwell_jitter_s: f64,
    /// Pause between passes in seconds.
    pub pause_s: f64,
}

impl Protocol {
    /// The paper's calibration: the calculated angle over ±1.7° in steps of 0.1°, three passes forward and
    /// three backward, 210 readings.
    pub fn calibration() -> Self {
        Self {
            range_deg: (-1.7, 1.7),
            step_deg: 0.1,
            passes: 6,
            dwell_s: 3.0,
            dwell_jitter_s: 0.5,
            pause_s: 30.0,
        }
    }

    /// The paper's verification: steps of 0.2°, three passes forward and three backward. The angles end at
    /// ±1.4°, so that a *corrected* angle that lands on them stays inside what the calibration covered
    /// (true angles −1.42° … +1.46°), noise included.
    pub fn verification() -> Self {
        Self { range_deg: (-1.4, 1.4), step_deg: 0.2, ..Self::calibration() }
    }

    /// The commanded angles of one forward pass in degrees, free of accumulated rounding.
    pub fn angles_deg(&self) -> Vec<f64> {
        let (first, last) = self.range_deg;
        let steps = ((last - first) / self.step_deg).round() as u32;
        (0..=steps).map(|i| first + f64::from(i) * self.step_deg).collect()
    }
}
