//! The second axis of the mirror shows in the first.

use fitter::terms::{Operator, Product};

use super::{Effect, Handed, Place, Reading, present, reading};
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
        "Yuan, Long & Yang, A review on autocollimators, Opt. Lasers Eng. (2005): crosstalk of the axes"
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
        let unit = &rows.unit;
        vec![reading(format!("coefficient_{unit}_per_arcsec"), amplitudes[0], format!("{unit}/arcsec"))]
    }
}
