//! One step of the classical fourth-order Runge–Kutta rule, in room that is used again and in the widest registers
//! that the processor has: most of the time of a dynamic diagnosis is spent here.

use std::ops::Mul;

use physics::number::Number;
use pulp::{Simd, WithSimd};

use super::machine::{Machine, State};
use super::span::Span;

/// Room for a step.
pub struct Room<T, const Z: usize, const Q: usize> {
    /// The state after it.
    pub to: State<T, Z, Q>,
    rates: State<T, Z, Q>,
    there: State<T, Z, Q>,
}

impl<T: Number, const Z: usize, const Q: usize> Room<T, Z, Q> {
    /// Room for steps.
    pub fn empty() -> Room<T, Z, Q> {
        Room { to: State::zero(), rates: State::zero(), there: State::zero() }
    }
}

/// One step, which has derivatives of its length only where an event ends it.
pub(super) struct Step<'a, 'm, T, H, const Z: usize, const Q: usize> {
    pub machine: &'a Machine<'m, T, Z, Q>,
    pub room: &'a mut Room<T, Z, Q>,
    pub state: &'a State<T, Z, Q>,
    pub h: H,
    pub span: &'a Span<T>,
    pub direction: f64,
}

impl<T: Number, H: Number, const Z: usize, const Q: usize> WithSimd for Step<'_, '_, T, H, Z, Q>
where
    T: Mul<H, Output = T>,
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Step { machine, room: Room { to, rates, there }, state, h, span, direction } = self;
        let length = |part: f64| (h * part, h.value() * part);
        machine.copy(to, state);
        machine.rates(state, &span.from, direction, rates);
        machine.advance(to, length(1.0 / 6.0), rates);
        for (drive, weight, past) in
            [(&span.middle, 1.0 / 3.0, 0.5), (&span.middle, 1.0 / 3.0, 0.5), (&span.to, 1.0 / 6.0, 1.0)]
        {
            machine.copy(there, state);
            machine.advance(there, length(past), rates);
            machine.rates(there, drive, direction, rates);
            machine.advance(to, length(weight), rates);
        }
    }
}
