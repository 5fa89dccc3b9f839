//! Whether firmware can compute an effect before it was ever fitted, and about what that costs.

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Expressed, Operator, Scope, Term};

use crate::cost::{Core, Cost};
use crate::design::DesignError;
use crate::format::Format;
use crate::options::{Ends, Method, Options};
use crate::physics::{Further, PhysicsError, Tree};
use crate::routine::{self, RoutineError};

/// Half of the range of a pair of probes for which the cost is estimated, in radians: 1.7°.
const HALF_RANGE_RAD: f64 = 0.03;
/// Half of the range of a direct sensor without a turn, in its unit.
const HALF_RANGE: f64 = 1.0;
/// The effect is taken to be this part of the range: 1″ of ±1.7°.
const SIZE: f64 = 1.6e-4;
/// The bound that is asked for, as a part of the effect.
const BOUND: f64 = 0.01;

/// What an expression adds to a routine without any other term, where its inputs are `further` and calls come every
/// `period_s`; its factors are so large that it is about 1/6000 of the range, and the bound is 1 % of that.
///
/// # Errors
/// Why no firmware computes it.
pub fn expression(
    expressed: &Expressed,
    sensor: &Sensor,
    (further, period_s): (&[Further], f64),
    core: Core,
) -> Result<Cost, String> {
    let pair = matches!(sensor, Sensor::EddyCurrentPair { .. });
    let (from, to) = match sensor {
        Sensor::EddyCurrentPair { probe_distance_mm, .. } => {
            let half = HALF_RANGE_RAD * probe_distance_mm;
            (-half, half)
        }
        Sensor::Direct { revolution: Some(turn), .. } => (0.0, *turn),
        Sensor::Direct { .. } => (-HALF_RANGE, HALF_RANGE),
    };
    let model = ErrorModel { sensor: sensor.clone(), centre: 0.0, coefficients: vec![0.0, 1e-3] };
    let mut file = Coefficients::of_model(&model, from, to, "");
    let statistic = if pair { fitter::units::ARCSEC_PER_RAD } else { 1.0 };
    let range = statistic * (sensor.calculated(to) - sensor.calculated(from));
    let over = |name: &str| {
        let ends = [from, to].map(|reading| crate::physics::of_reading(sensor, name, reading));
        let given = further.iter().find(|input| input.observable == name);
        match (ends, given) {
            ([Some(from), Some(to)], _) => physics::Interval { from, to },
            (_, Some(Further { from, to, .. })) => physics::Interval { from: *from, to: *to },
            _ => physics::Interval::point(0.0),
        }
    };
    let factors = vec![1.0; expressed.factors.len()];
    let size = Tree::of(expressed, &factors, pair)?.interval(&over, period_s)?;
    let largest = size.from.abs().max(size.to.abs());
    let factor = if largest > 0.0 { SIZE * range / largest } else { 1.0 };
    let ends = Ends::default();
    let options = Options {
        routines: vec![ends.routine(Method::Fused, Format::Q31)],
        further: further.to_vec(),
        period_s: Some(period_s),
        bound: Some(BOUND * SIZE * range),
        ..Options::default()
    };
    let alone = Options { further: Vec::new(), ..options.clone() };
    let cost = |file: &Coefficients, options: &Options| {
        let routine = routine::design(file, options, &options.routines[0]).map_err(reason)?;
        if let Some(left_out) = routine.physics.left_out.first() {
            return Err(left_out.why.split(';').next().unwrap_or_default().to_string());
        }
        Ok::<Cost, String>(core.cost(&routine.design.program))
    };
    let without = cost(&file, &alone)?;
    file.terms = vec![Term {
        effect: "effect".into(),
        scope: Scope::Device,
        operator: Operator::Expression(expressed.clone()),
        coefficients: vec![factor; factors.len()],
        covariance: Vec::new(),
    }];
    let with = cost(&file, &options)?;
    Ok(Cost {
        instructions: with.instructions - without.instructions,
        flash_bytes: with.flash_bytes - without.flash_bytes.min(with.flash_bytes),
    })
}

/// What is wrong, without what generation advises.
fn reason(error: RoutineError) -> String {
    match error {
        RoutineError::Design(DesignError::Physics(PhysicsError::NotGenerated { why, .. }))
        | RoutineError::Physics(PhysicsError::NotGenerated { why, .. }) => {
            why.trim_start_matches(": ").to_string()
        }
        RoutineError::Design(DesignError::Physics(PhysicsError::Needs { observable, .. })) => {
            format!("`{observable}` is not known at run time")
        }
        other => other.to_string(),
    }
}
