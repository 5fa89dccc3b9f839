//! The voice coil's field or force reaches the probes.

use fitter::terms::{Operator, Product};

use super::{Effect, Handed, Place, Reading, coefficient, present};
use crate::rows::Rows;

/// See the module's description.
pub struct CoilCrosstalk;

impl Effect for CoilCrosstalk {
    fn id(&self) -> &'static str {
        "coil_crosstalk"
    }

    fn title(&self) -> &'static str {
        "crosstalk of the coil current"
    }

    fn formula(&self) -> &'static str {
        "η · i, η in arcsec/A"
    }

    fn source(&self) -> &'static str {
        "Fleming, A review of nanometer resolution position sensors, Sens. Actuators A 190 (2013) 106–126, doi 10.1016/j.sna.2012.10.016: eddy-current sensors, sensitive to conductors and fields nearby"
    }

    fn size(&self) -> &'static str {
        "either sign; up to some hundred arcsec/A, where the current is some 0.1 A"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["cross_axis_coupling", "thermal_gain_drift"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("coil_a")
    }

    fn measured(&self) -> bool {
        true
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.coil_a, "coil_a").map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        rows.coil_a.clone().into_iter().collect()
    }

    fn operator(&self, _rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::plain(Operator::Product(Product::of("coil_a", 0.0)))
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], "a", "A")]
    }
}
