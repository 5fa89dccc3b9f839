//! A first-order lag on the way in or out, in closed form along a cubic.

use physics::number::Number;

/// One first-order lag τ w′ = u − w.
#[derive(Clone, Copy)]
pub struct Lag<T> {
    /// Its output.
    pub state: T,
    /// Time constant, s.
    tau: T,
    /// The last one that was needed.
    response: Response<T>,
}

/// What the lag does in a time along any input. Most times are those of a whole step, so that the last response is kept.
#[derive(Clone, Copy)]
struct Response<T> {
    /// s.
    time: T,
    /// τ over the time: ρ.
    ratio: T,
    /// e^(−1/ρ).
    decay: T,
    /// The moments of e^(−r/ρ), r from 0 to 1.
    moments: [T; 3],
}

/// How a lag goes along a cubic: w(r) = q(r) + A e^(−r/ρ), r from 0 to 1.
struct Course<T> {
    /// Coefficients of q.
    steady: [T; 4],
    /// A.
    transient: T,
}

impl<T: Number> Response<T> {
    fn new(time: T, tau: T) -> Response<T> {
        // Far below the step it is a shift by τ; this keeps the exponent finite.
        let least = 1e-9 * time.value();
        let tau = if tau.value() > least { tau } else { tau.chain(least, 1.0) };
        let ratio = tau / time;
        let one = T::from_f64(1.0);
        let decay = (-(one / ratio)).exp();
        let e0 = ratio * (one - decay);
        let e1 = ratio * (e0 - decay);
        let e2 = ratio * (e1 * 2.0 - decay);
        Response { time, ratio, decay, moments: [e0, e1, e2] }
    }

    /// Whether it is that in this time. Times with derivatives differ nearly always, and are not compared.
    fn is_in(&self, time: &T) -> bool {
        self.time.value() == time.value() && !self.time.moves() && !time.moves()
    }

    fn course(&self, state: T, [c0, c1, c2, c3]: [T; 4]) -> Course<T> {
        // q solves ρ q′ = u − q: q = u − ρ u′ + ρ² u″ − ρ³ u‴.
        let q3 = c3;
        let q2 = c2 - self.ratio * q3 * 3.0;
        let q1 = c1 - self.ratio * q2 * 2.0;
        let q0 = c0 - self.ratio * q1;
        Course { steady: [q0, q1, q2, q3], transient: state - q0 }
    }
}

impl<T: Number> Lag<T> {
    /// With its output and its time constant in s, for steps of mostly `step_s`.
    pub fn new(state: T, tau: T, step_s: f64) -> Lag<T> {
        Lag { state, tau, response: Response::new(T::from_f64(step_s), tau) }
    }

    /// In the wake of an input that has been running straight.
    pub fn behind(input: T, rate: T, tau: T, step_s: f64) -> Lag<T> {
        Lag::new(input - rate * tau, tau, step_s)
    }

    fn response(&mut self, time: T) -> &Response<T> {
        if !self.response.is_in(&time) {
            self.response = Response::new(time, self.tau);
        }
        &self.response
    }

    /// Towards a constant input, in a time in s that has no length but derivatives.
    pub fn begin(&mut self, input: T, time: T) {
        self.state += (input - self.state) * (time / self.tau);
    }

    /// On along a cubic that takes `time`, in s; the output there.
    pub fn advance(&mut self, input: [T; 4], time: T) -> T {
        let state = self.state;
        let response = self.response(time);
        let Course { steady: [q0, q1, q2, q3], transient } = response.course(state, input);
        self.state = q0 + q1 + q2 + q3 + transient * response.decay;
        self.state
    }

    /// The same, and the moments ∫ w dr, ∫ r w dr and ∫ r² w dr of the output on the way.
    pub fn pass(&mut self, input: [T; 4], time: T) -> [T; 3] {
        let state = self.state;
        let response = self.response(time);
        let Course { steady, transient } = response.course(state, input);
        let ([q0, q1, q2, q3], [m0, m1, m2], [e0, e1, e2]) = (steady, moments(steady), response.moments);
        self.state = q0 + q1 + q2 + q3 + transient * response.decay;
        [m0 + transient * e0, m1 + transient * e1, m2 + transient * e2]
    }

    /// The output half-way along a cubic.
    pub fn half_way(&mut self, input: [T; 4], time: T) -> T {
        let state = self.state;
        let response = self.response(time);
        let Course { steady: [q0, q1, q2, q3], transient } = response.course(state, input);
        let half = (-(T::from_f64(0.5) / response.ratio)).exp();
        q0 + q1 * 0.5 + q2 * 0.25 + q3 * 0.125 + transient * half
    }
}

/// ∫ u dr, ∫ r u dr and ∫ r² u dr of a cubic, r from 0 to 1.
pub fn moments<T: Number>([a, b, c, d]: [T; 4]) -> [T; 3] {
    [
        a + b * (1.0 / 2.0) + c * (1.0 / 3.0) + d * (1.0 / 4.0),
        a * (1.0 / 2.0) + b * (1.0 / 3.0) + c * (1.0 / 4.0) + d * (1.0 / 5.0),
        a * (1.0 / 3.0) + b * (1.0 / 4.0) + c * (1.0 / 5.0) + d * (1.0 / 6.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the lag's differential equation in ten thousand steps.
    #[test]
    fn a_cubic_passes_as_the_equation_says() {
        let cubic = [0.7, -1.2, 0.4, 2.0];
        let (time, steps) = (5e-4, 10_000);
        for tau in [3e-5, 2e-4, 3e-3] {
            let (mut w, mut sums, mut half) = (0.3, [0.0; 3], 0.0);
            let dr = 1.0 / steps as f64;
            for k in 0..steps {
                let u = |r: f64| cubic[0] + r * (cubic[1] + r * (cubic[2] + r * cubic[3]));
                let r = k as f64 * dr;
                let rate = |r: f64, w: f64| (u(r) - w) * time / tau;
                let middle = w + 0.5 * dr * rate(r, w);
                (0..3).for_each(|p| sums[p] += dr * (r + 0.5 * dr).powi(p as i32) * middle);
                w += dr * rate(r + 0.5 * dr, middle);
                if k + 1 == steps / 2 {
                    half = w;
                }
            }
            let mut lag = Lag::new(0.3, tau, time);
            assert!((lag.half_way(cubic, time) - half).abs() < 1e-6);
            let moments = lag.pass(cubic, time);
            assert!((lag.state - w).abs() < 1e-6, "{tau}: {} {w}", lag.state);
            for (a, b) in moments.iter().zip(sums) {
                assert!((a - b).abs() < 1e-6, "{tau}: {a} {b}");
            }
            assert_eq!(Lag::new(0.3, tau, 2.0 * time).advance(cubic, time), lag.state);
        }
    }
}
