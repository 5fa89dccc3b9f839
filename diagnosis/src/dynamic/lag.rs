//! A first-order lag on the way in or out.

use super::number::Number;

/// One first-order lag, exact where its input runs straight.
#[derive(Clone, Copy)]
pub struct Lag<T> {
    /// Its output.
    pub state: T,
    /// Its input.
    pub input: T,
}

impl<T: Number> Lag<T> {
    /// At rest at an input.
    pub fn at_rest(input: T) -> Lag<T> {
        Lag { state: input, input }
    }

    /// On to an input, `time` later; the output there.
    pub fn advance(&mut self, input: T, time: f64, tau: T) -> T {
        // Far below the step it is a shift by τ; this keeps the exponent finite.
        let tau = if tau.value() > 1e-9 * time { tau } else { tau.chain(1e-9 * time, 1.0) };
        let ratio = tau * (1.0 / time);
        let decay = (-(T::from_f64(1.0) / ratio)).exp();
        let behind = (input - self.input) * ratio;
        self.state = input - behind + (self.state - self.input + behind) * decay;
        self.input = input;
        self.state
    }
}
