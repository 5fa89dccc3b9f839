//! A first-order lag: τ dy/dt = e − y. Between two rows e is taken as a straight line, for which there is a closed form.

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, parameters};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};
use crate::unit::Unit;

static FORM: Form =
    Form::new(Operation::LowPass, "lowpass", "lowpass(e, tau) or lowpass(e, tau, start)", 2..=3);

/// See the module.
pub struct LowPass;

impl Operator for LowPass {
    fn form(&self) -> &Form {
        &FORM
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        let seconds = of_time(&of[1])?;
        let values: Vec<Quantity> = of.iter().take(1).chain(of.get(2)).cloned().collect();
        let (unit, mut factors) = common(&values)?;
        factors.insert(1, seconds);
        Ok((unit, factors))
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        if of[1].from <= 0.0 {
            return Err(format!("the time constant runs down to {} s, expected above zero", of[1].from));
        }
        let start = of.get(2).unwrap_or(&of[0]);
        Ok(Interval { from: of[0].from.min(start.from), to: of[0].to.max(start.to) })
    }

    fn value(&self, of: &[Value], time: &Time) -> Value {
        let (value, tau, start) = (&of[0], &of[1], of.get(2).unwrap_or(&of[0]));
        let indices = parameters(of);
        let count = time.t_s.len();
        let mut rows = Vec::with_capacity(count);
        let mut slopes: Vec<(usize, Vec<f64>)> =
            indices.iter().map(|p| (*p, Vec::with_capacity(count))).collect();
        let mut state = start.at(0);
        let mut states: Vec<f64> = indices.iter().map(|p| start.slope(*p, 0)).collect();
        // Most steps are as long as the one before.
        let mut last = (0.0, (0.0, 0.0));
        for row in 0..count {
            let before = row.saturating_sub(1);
            let ratio = (time.t_s[row] - time.t_s[before]).max(0.0) / tau.at(row);
            if ratio > 0.0 {
                // y' = y + gone (e − y) + (e' − e) rest, with gone = 1 − exp(−Δt/τ) and rest = 1 − gone τ/Δt.
                if ratio != last.0 {
                    let gone = -(-ratio).exp_m1();
                    last = (ratio, (gone, 1.0 - gone / ratio));
                }
                let (gone, rest) = last.1;
                let (e, next) = (value.at(before), value.at(row));
                // Derivatives of both by Δt/τ.
                let (d_gone, d_rest) = (1.0 - gone, (gone / ratio - (1.0 - gone)) / ratio);
                for (index, own) in indices.iter().zip(&mut states) {
                    let (de, d_next) = (value.slope(*index, before), value.slope(*index, row));
                    let d_ratio = -ratio / tau.at(row) * tau.slope(*index, row);
                    *own += gone * (de - *own)
                        + (d_next - de) * rest
                        + d_ratio * (d_gone * (e - state) + (next - e) * d_rest);
                }
                state += gone * (e - state) + (next - e) * rest;
            }
            rows.push(state);
            for ((_, slopes), own) in slopes.iter_mut().zip(&states) {
                slopes.push(*own);
            }
        }
        Value { rows, slopes }
    }

    fn degree(&self, of: &[u32]) -> Option<u32> {
        (of[1] == 0 && of.get(2).is_none_or(|start| *start == of[0])).then_some(of[0])
    }

    fn remembers(&self) -> bool {
        true
    }
}

/// The factor that makes seconds of a time.
pub(super) fn of_time(quantity: &Quantity) -> Result<f64, UnitError> {
    match quantity {
        Quantity::Number(_) => Ok(1.0),
        Quantity::Of(unit) => {
            unit.in_units_of(&Unit::named("s")).ok_or_else(|| UnitError::Needs(unit.clone(), "a time"))
        }
    }
}
