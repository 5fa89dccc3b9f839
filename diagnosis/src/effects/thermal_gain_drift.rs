//! The scale of the displacement probes changes with temperature.

use fitter::terms::{Operator, Product};

use super::{Effect, Experiment, Facts, Handed, Reading, angle_observable, mean_of, present, reading};
use crate::numerics::centred;
use crate::rows::Rows;

/// See the module's description.
pub struct ThermalGainDrift;

impl Effect for ThermalGainDrift {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "thermal_gain_drift",
                title: "gain drift with temperature",
                formula: "γ·10⁻⁶ θ (T − T̄), γ in ppm/K",
                source: "Fleming, A review of nanometer resolution position sensors, Sens. Actuators A 190 (2013) 106–126, doi 10.1016/j.sna.2012.10.016: drift of the sensitivity",
                size: "either sign; some to some hundred ppm/K for eddy-current probes",
                confused_with: &["thermal_lag", "coil_crosstalk"],
                variable: "temperature_c",
                times: Some("angle_deg"),
                told_by: &[(Experiment::Levels, "temperature"), (Experiment::OneByOne, "temperature")],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.temperature_c, "temperature_c").map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        let product =
            |t: &Vec<f64>| centred(t).iter().zip(&rows.theta).map(|(t, theta)| 1e-6 * theta * t).collect();
        rows.temperature_c.iter().map(product).collect()
    }

    fn operator(&self, rows: &Rows, _shape: &[f64]) -> Handed {
        let product =
            Product::of("temperature_c", mean_of(&rows.temperature_c)).times(angle_observable(rows), 0.0, 1);
        Handed::scaled(Operator::Product(product), 1e-6)
    }

    fn readings(&self, _rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![reading("coefficient_ppm_per_k", amplitudes[0], "ppm/K")]
    }
}
