//! Plain dependences on one observable: a coefficient times its column.

use fitter::terms::{Operator, Product};

use super::{Effect, Experiment, Facts, Handed, Reading, coefficient, mean_of, present};
use crate::numerics::centred;
use crate::rows::Rows;

/// A plain dependence.
pub struct Dependence {
    facts: Facts,
    /// The observable, and its name for a reader.
    column: fn(&Rows) -> &Option<Vec<f64>>,
    name: &'static str,
    /// The observable's unit in the coefficient's name, and as it is printed.
    per: (&'static str, &'static str),
    /// Whether it counts from its mean over the recording.
    from_mean: bool,
}

/// The zero of the angle moves with the temperature of the base plate.
pub static THERMAL_ZERO_DRIFT: Dependence = Dependence {
    facts: Facts {
        id: "thermal_zero_drift",
        title: "zero drift with temperature",
        formula: "k (T − T̄), k in arcsec/K",
        source: "Fleming, A review of nanometer resolution position sensors, Sens. Actuators A 190 (2013) 106–126, doi 10.1016/j.sna.2012.10.016: drift of the offset",
        size: "either sign; 0.01 to some arcsec/K for a metal frame",
        confused_with: &["thermal_lag", "time_drift", "warmup_drift"],
        variable: "temperature_c",
        told_by: &[
            (Experiment::Levels, "temperature"),
            (Experiment::Jump, "at once"),
            (Experiment::OneByOne, "temperature"),
        ],
        ..Facts::USUAL
    },
    column: |rows| &rows.temperature_c,
    name: "temperature_c",
    per: ("k", "K"),
    from_mean: true,
};

/// A translation of the mirror leaks into the angle: the probes differ in gain.
pub static COMMON_MODE_LEAKAGE: Dependence = Dependence {
    facts: Facts {
        id: "common_mode_leakage",
        title: "common-mode leakage",
        formula: "λ (x₁+x₂)/2, λ in arcsec/µm",
        source: "Fan et al., Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and Correction, Sensors 19 (2019) 367, Eq. 1: the common mode cancels in x₂ − x₁ only where the probes are alike",
        size: "either sign; 34.4 g arcsec/µm where the gains are 1 ± g and the probes 12 mm apart, g from 0.001 to 0.1",
        confused_with: &["cross_axis_coupling", "coil_crosstalk"],
        variable: "common_mode_um",
        measured: true,
        of_common_mode: true,
        told_by: &[(Experiment::OneByOne, "mount")],
        ..Facts::USUAL
    },
    column: |rows| &rows.common_mode_um,
    name: "common mode of x1_mm and x2_mm",
    per: ("um", "um"),
    from_mean: false,
};

/// The second axis of the mirror shows in the first.
pub static CROSS_AXIS_COUPLING: Dependence = Dependence {
    facts: Facts {
        id: "cross_axis_coupling",
        title: "coupling of the second axis",
        formula: "χ · cross, χ in arcsec/arcsec",
        source: "Geckeler, Kranz, Just & Krause, A novel approach for extending autocollimator calibration from plane to spatial angles, Adv. Opt. Technol. 1 (2012) 427–439: crosstalk of the axes",
        size: "either sign; about the axes' misalignment, 0.001 to 0.1, more where a probe is off its axis",
        confused_with: &["common_mode_leakage", "coil_crosstalk"],
        variable: "cross_arcsec",
        measured: true,
        told_by: &[(Experiment::OneByOne, "second axis")],
        ..Facts::USUAL
    },
    column: |rows| &rows.cross_arcsec,
    name: "cross_arcsec",
    per: ("arcsec", "arcsec"),
    from_mean: false,
};

/// The voice coil's field or force reaches the probes.
pub static COIL_CROSSTALK: Dependence = Dependence {
    facts: Facts {
        id: "coil_crosstalk",
        title: "crosstalk of the coil current",
        formula: "η · i, η in arcsec/A",
        source: "Fleming, A review of nanometer resolution position sensors, Sens. Actuators A 190 (2013) 106–126, doi 10.1016/j.sna.2012.10.016: eddy-current sensors, sensitive to conductors and fields nearby",
        size: "either sign; up to some hundred arcsec/A, where the current is some 0.1 A",
        confused_with: &["cross_axis_coupling", "thermal_gain_drift"],
        variable: "coil_a",
        measured: true,
        told_by: &[(Experiment::OneByOne, "coil")],
        ..Facts::USUAL
    },
    column: |rows| &rows.coil_a,
    name: "coil_a",
    per: ("a", "A"),
    from_mean: false,
};

impl Effect for &'static Dependence {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present((self.column)(rows), self.name).map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        let values = (self.column)(rows).iter();
        values.map(|values| if self.from_mean { centred(values) } else { values.clone() }).collect()
    }

    fn operator(&self, rows: &Rows, _shape: &[f64]) -> Handed {
        let mean = if self.from_mean { mean_of((self.column)(rows)) } else { 0.0 };
        Handed::plain(Operator::Product(Product::of(self.facts.variable, mean)))
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], self.per.0, self.per.1)]
    }
}
