//! The zero of the angle moves with the temperature of the base plate.

use fitter::terms::{Operator, Product};

use super::{Effect, Handed, Place, Reading, coefficient, mean_of, present};
use crate::rows::{Rows, centred};

/// See the module's description.
pub struct ThermalZeroDrift;

impl Effect for ThermalZeroDrift {
    fn id(&self) -> &'static str {
        "thermal_zero_drift"
    }

    fn title(&self) -> &'static str {
        "zero drift with temperature"
    }

    fn formula(&self) -> &'static str {
        "k (T − T̄), k in arcsec/K"
    }

    fn source(&self) -> &'static str {
        "Fleming, A review of nanometer resolution position sensors, Sens. Actuators A 190 (2013) 106–126, doi 10.1016/j.sna.2012.10.016: drift of the offset"
    }

    fn size(&self) -> &'static str {
        "either sign; 0.01 to some arcsec/K for a metal frame"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["thermal_lag", "time_drift", "warmup_drift"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("temperature_c")
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.temperature_c, "temperature_c").map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        rows.temperature_c.iter().map(|t| centred(t)).collect()
    }

    fn operator(&self, rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::plain(Operator::Product(Product::of("temperature_c", mean_of(&rows.temperature_c))))
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], "k", "K")]
    }
}
