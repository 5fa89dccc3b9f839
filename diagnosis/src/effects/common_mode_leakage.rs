//! A translation of the mirror leaks into the angle: the probes differ in gain.

use fitter::terms::{Operator, Product};

use super::{Effect, Handed, Place, Reading, coefficient, present};
use crate::rows::Rows;

/// See the module's description.
pub struct CommonModeLeakage;

impl Effect for CommonModeLeakage {
    fn id(&self) -> &'static str {
        "common_mode_leakage"
    }

    fn title(&self) -> &'static str {
        "common-mode leakage"
    }

    fn formula(&self) -> &'static str {
        "λ (x₁+x₂)/2, λ in arcsec/µm"
    }

    fn source(&self) -> &'static str {
        "Fan et al., Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and Correction, Sensors 19 (2019) 367, Eq. 1: the common mode cancels in x₂ − x₁ only where the probes are alike"
    }

    fn size(&self) -> &'static str {
        "either sign; 34.4 g arcsec/µm where the gains are 1 ± g and the probes 12 mm apart, g from 0.001 to 0.1"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["cross_axis_coupling", "coil_crosstalk"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("common_mode_um")
    }

    fn measured(&self) -> bool {
        true
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.common_mode_um, "common mode of x1_mm and x2_mm").map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        rows.common_mode_um.clone().into_iter().collect()
    }

    fn operator(&self, _rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::plain(Operator::Product(Product::of("common_mode_um", 0.0)))
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], "um", "um")]
    }
}
