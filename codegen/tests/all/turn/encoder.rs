//! Encoders for tests.

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Operator, Periodic, Scope, Term};
use fitter::turn::Turn;

/// A sensor of this revolution with a zero and harmonics 1, 2 …: cosine and sine in turn, in its unit.
pub(crate) fn encoder(revolution: f64, zero: f64, waves: &[f64]) -> Coefficients {
    let unit = if revolution == 360.0 { "deg" } else { "counts" };
    let sensor = Sensor::Direct { unit: unit.into(), revolution: Some(revolution) };
    let model = ErrorModel { sensor, centre: 0.5 * revolution, coefficients: vec![zero] };
    let mut file = Coefficients::of_model(&model, 0.0, revolution, "by hand");
    file.turn = Some(Turn::single(revolution));
    file.terms.push(Term {
        effect: "periodic_error".into(),
        scope: Scope::Device,
        operator: Operator::Periodic(Periodic::of(revolution, (waves.len() / 2) as u16)),
        coefficients: waves.to_vec(),
        covariance: Vec::new(),
    });
    file
}
