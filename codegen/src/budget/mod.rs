//! The uncertainty budget of a routine after the GUM: what the recording showed and what was stated of the reference
//! ([`fitter::budget`]), with what is proved of the arithmetic and what input and output round.

mod model;
mod reading;
mod turn;
mod words;

use fitter::budget::{At, Budget, COVERAGE, Component, Distribution, Evaluation, reference, type_a};
use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;

use crate::extent::LeftOut;

pub(crate) use model::{Known, quadratic};
pub use reading::of_routine;
pub(crate) use reading::{of_axis, of_page};
pub(crate) use turn::{of_ring, of_turn};
pub use words::in_words;

/// The table has a place at every tenth of the range.
const TENTHS: u32 = 10;

const FORMULA: &str = "y − Y = Σ cᵢ·δᵢ; u_c² = Σ cᵢ²·u²(xᵢ); ν_eff = u_c⁴ / Σ (cᵢ⁴·u⁴(xᵢ)/νᵢ); U = k·u_c, k being the \
                       95 % reach of the distribution that the components have together";

/// The ends of the tenths of a range.
fn tenths(from: f64, to: f64) -> Vec<f64> {
    (0..=TENTHS).map(|i| from + (to - from) * f64::from(i) / f64::from(TENTHS)).collect()
}

/// What of a budget depends on the routine. Lengths without a unit are in the budget's.
struct Parts {
    /// What errs.
    subject: String,
    /// Unit of the budget.
    unit: String,
    /// What a place is, and its unit.
    place: (String, String),
    /// Where the table has its lines.
    places: Vec<Line>,
    /// How well the model is known at the places, and at the points of the file's statistics; none where the file does not
    /// tell it.
    model: Option<[Vec<Known>; 2]>,
    /// What is proved of everything but the rounding of the result.
    arithmetic: f64,
    /// What the rounding of the result takes at most.
    output: f64,
    /// The step of the input.
    step: Step,
    /// What the routine leaves out.
    left_out: Vec<LeftOut>,
    /// Half of what the directions differ by, uncorrected.
    direction: f64,
    /// The inputs beside the reading.
    further: Vec<String>,
    /// Effects of terms with a time constant, a threshold, a width or a period that was fitted.
    shapes: Vec<String>,
    /// Whether the zero of the result is set by other means.
    zero_elsewhere: bool,
}

/// A line of the table.
#[derive(Clone, Copy)]
struct Line {
    place: f64,
    /// The reading there, in its own unit.
    reading: f64,
    /// The corrected reading, in the budget's unit.
    result: f64,
    /// Its slope by the reading.
    slope: f64,
}

/// The step of a routine's input.
struct Step {
    /// In the unit of the reading; 0 of a float.
    size: f64,
    /// Unit of the reading.
    unit: String,
    /// Whether two inputs of this step are subtracted.
    difference: bool,
}

impl Parts {
    /// The budget; none where the file does not say what the recording showed.
    fn budget(self, file: &Coefficients) -> Option<Budget> {
        file.noise()?;
        let places = (self.places.iter().enumerate())
            .map(|(index, at)| self.at(file, index, *at))
            .collect::<Option<Vec<_>>>()?;
        let mut missing: Vec<String> = reference::missing(file).into_iter().collect();
        missing.extend(type_a::missing(file));
        let budget = Budget {
            measurand: self.measurand(file),
            coverage: COVERAGE,
            formula: FORMULA.into(),
            not_included: self.not_included(file),
            missing,
            unit: self.unit,
            place: self.place.0,
            place_unit: self.place.1,
            at: 0.0,
            components: Vec::new(),
            range: Vec::new(),
        };
        budget.over(places)
    }

    /// All components at a place, those that are nothing there among them.
    fn at(&self, file: &Coefficients, index: usize, line: Line) -> Option<At> {
        let Line { place, reading, result, slope } = line;
        let unit = &self.unit;
        let nothing = |source| Component::within(source, "", unit, 0.0);
        // Rows that are not independent tell less of what was fitted to them.
        let more = type_a::of_fitted(file).sqrt();
        let here = self.model.as_ref().map(|[places, _]| &places[index]);
        let model = here.map(|known| {
            let what = "model: interval of the fitted coefficients";
            Component::observed("model", what, unit, more * known.rest, freedom_of_fit(file))
        });
        let term = |of: &model::OfTerm| {
            let deviation = more * of.deviation;
            Component::observed("term", &of.what, &of.unit, deviation, freedom_of_fit(file))
                .times(of.sensitivity)
        };
        let at_points = self.model.iter().flat_map(|[_, points]| points);
        let at_points: Vec<f64> = at_points.map(|known| more * known.deviation()).collect();
        let within = |source, what, half| Component::within(source, what, unit, half);
        let mut components = vec![
            reference::reference(file).unwrap_or_else(|| nothing("reference")),
            type_a::repeatability(file, reading)?,
            model.unwrap_or_else(|| nothing("model")),
            type_a::lack_of_fit(file, reading, &at_points).unwrap_or_else(|| nothing("lack_of_fit")),
            type_a::pass_offset(file).unwrap_or_else(|| nothing("pass_offset")),
            self.of_direction(),
            within(
                "left_out",
                "terms: largest value of those that the routine leaves out",
                self.left_out.iter().filter_map(|out| out.size).sum(),
            ),
            within("arithmetic", "arithmetic: proven bound", self.arithmetic),
            within("output", "output: rounding of the result", self.output),
            self.step.component(file).times(slope),
        ];
        components.extend(here.iter().flat_map(|known| &known.terms).map(term));
        Some(At { place, result, components })
    }

    /// A count alone does not tell from where it was approached.
    fn of_direction(&self) -> Component {
        let what = "direction: half of what forward and backward differ by";
        let half = Component::of("direction", what, &self.unit, self.direction, Distribution::TwoValued, 1.0);
        Component { evaluation: Evaluation::A, ..half }
    }

    fn measurand(&self, file: &Coefficients) -> String {
        let zero = file.identification.as_ref().and_then(|i| i.zero.as_ref());
        let from = match (&file.sensor, zero) {
            (Sensor::EddyCurrentPair { .. }, Some(zero)) => {
                format!("the true angle, counted from α₀ = {} arcsec on", zero.alpha0_arcsec)
            }
            (Sensor::EddyCurrentPair { .. }, None) => "the true angle on".to_string(),
            (Sensor::Direct { .. }, _) => "the true value on".to_string(),
        };
        let subject = &self.subject;
        format!(
            "the error of {subject}, against {from} the reference's scale, in the conditions of the recording"
        )
    }

    fn not_included(&self, file: &Coefficients) -> Vec<String> {
        let mut list = vec![
            "other conditions than those of the recording: temperatures, speeds, mounting, ageing"
                .to_string(),
            "readings outside the range".to_string(),
        ];
        let covered = &file.valid_range;
        if self.places.iter().any(|line| !covered.contains(line.reading)) {
            let (from, to) = (covered.from, covered.to);
            list.push(format!("lack of fit beyond what was recorded, {from} … {to} {}", file.units.reading));
        }
        if file.whole_turn() && !type_a::repeats(file) {
            list.push(
                "a correlation of neighbouring readings: no angle repeats, so none was looked for"
                    .to_string(),
            );
        }
        if self.zero_elsewhere {
            list.push("the zero, which the firmware sets by other means".to_string());
        }
        if !self.further.is_empty() {
            list.push(format!("errors and steps of the further inputs: {}", self.further.join(", ")));
        }
        if !self.shapes.is_empty() {
            list.push(format!(
                "intervals of time constants, thresholds, widths and periods, which are taken as fitted: {}",
                self.shapes.join(", ")
            ));
        }
        let without_size = self.left_out.iter().filter(|out| out.size.is_none());
        list.extend(without_size.map(|out| format!("left out of the routine: {out}")));
        let zero = file.identification.as_ref().and_then(|i| i.zero.as_ref());
        if let Some(error) = zero.and_then(|zero| zero.standard_error_arcsec) {
            list.push(format!(
                "the standard error of α₀, {error:.2e} arcsec: it counts where angles are compared with those from another zero"
            ));
        }
        let recorded = file.recorded.as_ref();
        if recorded.is_some_and(|recorded| recorded.reference.repeatability.is_none()) {
            list.push(
                "a deduction for the noise of the reference, which is in the repeatability: its repeatability is not \
                 stated"
                    .to_string(),
            );
        }
        if self.step.size == 0.0 {
            list.push("the rounding of the reading before the routine is given it, as a float".to_string());
        } else if recorded.is_some_and(|recorded| recorded.reading_step > 0.0) {
            list.push(
                "the step of the readings as they were recorded a second time: it is in their scatter"
                    .to_string(),
            );
        }
        list
    }
}

impl Step {
    /// What one reading is rounded by, beyond what the recorded readings were: that is in their scatter, or in what the
    /// fit leaves of their means.
    fn component(&self, file: &Coefficients) -> Component {
        let recorded = file.recorded.as_ref().map_or(0.0, |recorded| recorded.reading_step);
        let beyond = (self.size * self.size - recorded * recorded).max(0.0).sqrt();
        let unit = &self.unit;
        if self.difference {
            let what = "input: step of the readings of both probes";
            Component::of("input", what, unit, beyond, Distribution::Triangular, 6f64.sqrt())
        } else {
            Component::within("input", "input: step of the reading", unit, 0.5 * beyond)
        }
    }
}

/// Degrees of freedom of the fit: of a diagnosed file the readings less the coefficients.
fn freedom_of_fit(file: &Coefficients) -> f64 {
    let of_fit = file.identification.as_ref().map(|i| i.degrees_of_freedom);
    let freedom = of_fit.unwrap_or_else(|| file.recording.rows.saturating_sub(file.count_of_all()));
    (type_a::independent(file) * freedom as f64).max(1.0)
}

/// What errs, unless it is a machine.
fn subject(file: &Coefficients) -> String {
    let what = match &file.sensor {
        Sensor::EddyCurrentPair { .. } => "angle",
        Sensor::Direct { .. } => "reading",
    };
    format!("one corrected {what} of this device, from a single reading")
}
