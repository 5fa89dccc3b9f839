//! The second axis of the mirror shows in the first.

use fitter::terms::{Operator, Product};

use super::{Effect, Handed, Place, Reading, coefficient, present};
use crate::rows::Rows;

/// See the module's description.
pub struct CrossAxisCoupling;

impl Effect for CrossAxisCoupling {
    fn id(&self) -> &'static str {
        "cross_axis_coupling"
    }

    fn title(&self) -> &'static str {
        "coupling of the second axis"
    }

    fn formula(&self) -> &'static str {
        "χ · cross, χ in arcsec/arcsec"
    }

    fn source(&self) -> &'static str {
        "Geckeler, Kranz, Just & Krause, A novel approach for extending autocollimator calibration from plane to spatial angles, Adv. Opt. Technol. 1 (2012) 427–439: crosstalk of the axes"
    }

    fn size(&self) -> &'static str {
        "either sign; about the axes' misalignment, 0.001 to 0.1, more where a probe is off its axis"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["common_mode_leakage", "coil_crosstalk"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("cross_arcsec")
    }

    fn measured(&self) -> bool {
        true
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.cross_arcsec, "cross_arcsec").map(drop)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        rows.cross_arcsec.clone().into_iter().collect()
    }

    fn operator(&self, _rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::plain(Operator::Product(Product::of("cross_arcsec", 0.0)))
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], "arcsec", "arcsec")]
    }
}
