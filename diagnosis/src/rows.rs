//! What a diagnosis sees of a recording: the angular error of every row, the base model's columns, and the
//! observables on which a mismatch may depend. Everything here is in the recording's own unit (arcsec for
//! an eddy-current pair, the sensor's unit otherwise).

use std::collections::BTreeMap;

use crate::noise::Sort;
use crate::thresholds::rows::{COMMON, MOST_PAUSES, PAUSE, SAME_PLACE};
use fitter::turn::Turn;
use numerics::{least_squares, mean, median, range};

/// One observable of a recording.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name, as it stands in `locations`.
    pub name: String,
    /// Its value at every row.
    pub values: Vec<f64>,
}

/// The rows of a recording as a diagnosis needs them; every vector has one entry per row.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Unit of the angle and its error: `arcsec`, or that of a direct sensor.
    pub unit: String,
    /// Whether the sensor is an eddy-current pair (Eq. 6) or reports the angle or position itself.
    pub pair: bool,
    /// Whether a row is the mean of several readings.
    pub means: bool,
    /// Time in seconds, not decreasing.
    pub t_s: Vec<f64>,
    /// Times in seconds, each the middle of a pause between two readings. Means over readings do not show them.
    pub pauses_s: Vec<f64>,
    /// Number of the pass.
    pub pass: Vec<i64>,
    /// +1 forward, −1 backward.
    pub direction: Vec<f64>,
    /// The reading that the base polynomial is written in: s in mm, or `measured`.
    pub reading: Vec<f64>,
    /// d/(s²+d²) in 1/mm (Eq. 6); 1 for a direct sensor.
    pub weight: Vec<f64>,
    /// The calculated angle θ (Eq. 1), or `measured`.
    pub theta: Vec<f64>,
    /// The true angle as the reference saw it, α₀ not removed.
    pub truth: Vec<f64>,
    /// The angular error Δθ_M = θ − Θ (Eq. 8), α₀ not removed; less the user's simulation where given.
    pub error: Vec<f64>,
    /// (x₁+x₂)/2 in µm, for a pair.
    pub common_mode_um: Option<Vec<f64>>,
    /// `cross_arcsec`.
    pub cross_arcsec: Option<Vec<f64>>,
    /// `temperature_c`.
    pub temperature_c: Option<Vec<f64>>,
    /// `coil_a`.
    pub coil_a: Option<Vec<f64>>,
    /// `command_deg`.
    pub command_deg: Option<Vec<f64>>,
    /// Any further numeric column; of many the strongest.
    pub extra: Vec<Column>,
    /// How many further columns there were where `extra` holds the strongest; else 0.
    pub further_columns: usize,
    /// What `fit` says of a sensor that turns round and round.
    pub turn: Option<Turn>,
    /// The order of the base, where it is given: by the user, or by `fit` for a whole turn.
    pub order: Option<usize>,
    /// What the recording cannot show and why (columns with blanks, constants, …).
    pub not_testable: Vec<String>,
}

impl Rows {
    /// What its rows are for an estimate of their noise.
    pub fn sort(&self) -> Sort {
        if self.means { Sort::Means } else { Sort::Readings }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// One whole turn in the recording's unit, where the base are harmonics of it.
    pub fn whole_turn(&self) -> Option<f64> {
        self.turn.as_ref().filter(|turn| turn.whole).map(|turn| turn.revolution)
    }

    /// How many columns of its name a further column stands for: 1 where all of them are searched, and for any other.
    pub fn stands_for(&self, name: &str) -> f64 {
        let further = self.extra.iter().any(|column| column.name == name);
        if further && self.further_columns > 0 {
            self.further_columns as f64 / self.extra.len() as f64
        } else {
            1.0
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Centre and half range of the reading; the base polynomial's argument is (reading − centre)/half.
    /// A pair is centred on 0 (Eq. 5).
    pub fn reading_scale(&self) -> (f64, f64) {
        let (low, high) = range(&self.reading);
        let centre = if self.pair { 0.0 } else { 0.5 * (low + high) };
        let half = (high - centre).abs().max((low - centre).abs());
        (centre, if half > 0.0 { half } else { 1.0 })
    }

    /// The reading scaled to −1 … 1.
    pub fn scaled_reading(&self) -> Vec<f64> {
        let (centre, half) = self.reading_scale();
        self.reading.iter().map(|r| (r - centre) / half).collect()
    }

    /// Lowest and highest θ.
    pub fn stroke(&self) -> (f64, f64) {
        range(&self.theta)
    }

    /// A typical distance in θ between neighbouring angles of one pass, in whatever order they were read. Readings
    /// taken at one place do not count.
    pub fn step(&self) -> f64 {
        let mut passes: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
        for (pass, theta) in self.pass.iter().zip(&self.theta) {
            passes.entry(*pass).or_default().push(*theta);
        }
        let mut steps: Vec<f64> = passes.values().flat_map(|angles| steps_apart(angles)).collect();
        if steps.is_empty() {
            steps = steps_apart(&self.theta);
        }
        median(&mut steps).max(1e-12)
    }

    /// Distinct positions at which readings were taken: what bounds the order of the base, however many rows there are
    /// at each of them.
    pub fn positions(&self) -> usize {
        steps_apart(&self.theta).len() + 1
    }

    /// Standard deviation, in the angle's unit, of the place on the angle at which something of one probe stands: the
    /// common mode moves both probes, and with each of them by c what stands at s moves by 2c. What the common mode does
    /// at every pass alike, a quartic of the reading, moves nothing. 0 without a common mode.
    pub fn scatter_of_places(&self) -> f64 {
        let Some(common_mode_um) = &self.common_mode_um else { return 0.0 };
        let x = self.scaled_reading();
        let powers: Vec<Vec<f64>> = (0..=4).map(|k| x.iter().map(|x| x.powi(k)).collect()).collect();
        let scatter_um = (least_squares(&powers, common_mode_um).rss / self.len() as f64).sqrt();
        2e-3 * scatter_um * self.angle_per_mm()
    }

    /// Noise of the common mode in µm at a noise of the angle of 1 in its unit, where all of it is the probes' own: in
    /// (x₁+x₂)/2 it is half of that in x₂ − x₁.
    pub fn common_mode_noise_um(&self) -> f64 {
        0.5e3 / self.angle_per_mm()
    }

    /// Change of a pair's angle, in its unit, with x₂ − x₁.
    fn angle_per_mm(&self) -> f64 {
        mean(&self.weight) * self.per_degree() * 1f64.to_degrees()
    }

    /// Duration in seconds.
    pub fn duration_s(&self) -> f64 {
        let (low, high) = range(&self.t_s);
        (high - low).max(1e-9)
    }

    /// The true angle per degree in this unit: 3600 for arcsec; for `deg` 1; otherwise 1 (edges then
    /// print the sensor's own unit).
    pub fn per_degree(&self) -> f64 {
        if self.unit == "arcsec" { 3600.0 } else { 1.0 }
    }

    /// Whether the recording has both directions.
    pub fn both_directions(&self) -> bool {
        self.direction.iter().any(|d| *d > 0.0) && self.direction.iter().any(|d| *d < 0.0)
    }

    /// Whether there is one pass only, so that time runs with the angle.
    pub fn single_move(&self) -> bool {
        self.pass.windows(2).all(|w| w[0] == w[1])
    }

    /// Numbers of the passes in order of appearance.
    pub fn passes(&self) -> Vec<i64> {
        let mut seen = std::collections::BTreeSet::new();
        let mut last = None;
        let mut passes: Vec<i64> = Vec::new();
        for p in &self.pass {
            if last != Some(*p) && seen.insert(*p) {
                passes.push(*p);
            }
            last = Some(*p);
        }
        passes
    }

    /// The same recording with every column put through `change` (a choice of rows, means over cells), and with
    /// the passes that then belong to its rows.
    pub fn changed(&self, pass: Vec<i64>, change: impl Fn(&[f64]) -> Vec<f64>) -> Rows {
        let some = |values: &Option<Vec<f64>>| values.as_ref().map(|v| change(v));
        Rows {
            unit: self.unit.clone(),
            pair: self.pair,
            means: self.means,
            t_s: change(&self.t_s),
            pauses_s: self.pauses_s.clone(),
            pass,
            direction: change(&self.direction),
            reading: change(&self.reading),
            weight: change(&self.weight),
            theta: change(&self.theta),
            truth: change(&self.truth),
            error: change(&self.error),
            common_mode_um: some(&self.common_mode_um),
            cross_arcsec: some(&self.cross_arcsec),
            temperature_c: some(&self.temperature_c),
            coil_a: some(&self.coil_a),
            command_deg: some(&self.command_deg),
            extra: self
                .extra
                .iter()
                .map(|c| Column { name: c.name.clone(), values: change(&c.values) })
                .collect(),
            further_columns: self.further_columns,
            turn: self.turn.clone(),
            order: self.order,
            not_testable: self.not_testable.clone(),
        }
    }
}

/// The middle of every pause between readings at these times, in seconds. Gaps that are common or many are no pauses.
pub fn pauses(t_s: &[f64]) -> Vec<f64> {
    let gap = |pair: &[f64]| pair[1] - pair[0];
    let usual = median(&mut t_s.windows(2).map(gap).filter(|gap| *gap > 0.0).collect::<Vec<f64>>());
    let is_pause = |pair: &&[f64]| gap(pair) > PAUSE * usual;
    let pauses: Vec<f64> = t_s.windows(2).filter(is_pause).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let most = MOST_PAUSES.min(COMMON * t_s.len() as f64);
    if pauses.len() as f64 > most { Vec::new() } else { pauses }
}

/// Distances between neighbouring positions.
fn steps_apart(angles: &[f64]) -> Vec<f64> {
    let mut sorted = angles.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (_, largest) = range(&steps);
    steps.retain(|step| *step > SAME_PLACE * largest);
    steps
}

#[cfg(test)]
mod tests {
    use super::pauses;

    #[test]
    fn a_gap_that_is_common_is_no_pause() {
        let times = |gap: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut t = 0.0;
            (0..60)
                .map(|k| {
                    t += gap(k);
                    t
                })
                .collect()
        };
        assert_eq!(pauses(&times(&|k| if k == 30 { 21.0 } else { 1.0 })), [40.5]);
        assert_eq!(pauses(&times(&|k| if k % 2 == 0 { 30.0 } else { 1.0 })), [0.0; 0]);
        let passes: Vec<f64> = (0..6000).map(|k| f64::from(k + k / 20 * 30)).collect();
        assert_eq!(pauses(&passes), [0.0; 0], "three hundred");
        assert_eq!(pauses(&passes[..400]).len(), 19);
        // Several readings have one time.
        assert_eq!(pauses(&times(&|k| if k % 3 == 0 { 1.0 } else { 0.0 })), [0.0; 0]);
    }
}
