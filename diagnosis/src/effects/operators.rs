//! Operators with memory that several signatures are made of.

/// The play operator of half width `r`: an output that follows `x` only once the gap is taken up, beginning at
/// `start`. Source: Brokate & Sprekels, "Hysteresis and Phase Transitions"
/// (1996), section 2.1.
pub fn play_from(x: &[f64], r: f64, start: f64) -> Vec<f64> {
    let mut p = start;
    x.iter()
        .map(|&x| {
            p = p.clamp(x - r, x + r);
            p
        })
        .collect()
}

/// First-order low pass, τ dz/dt = x − z, z(first row) = x(first row), with x linear between rows: exact for
/// unequal steps.
pub fn low_pass(t_s: &[f64], x: &[f64], tau_s: f64) -> Vec<f64> {
    let mut z = x.first().copied().unwrap_or(0.0);
    // Decay over a step, and the response to the ramp from x[i−1] to x[i]: most steps are as long as the one before.
    let over = |h: f64| {
        let a = h / tau_s;
        let decay = (-a).exp();
        (decay, if a > 1e-6 { 1.0 - (1.0 - decay) / a } else { 0.5 * a })
    };
    let mut last = (0.0, over(0.0));
    (0..x.len())
        .map(|i| {
            if i > 0 {
                let h = (t_s[i] - t_s[i - 1]).max(0.0);
                if h != last.0 {
                    last = (h, over(h));
                }
                let (decay, ramp) = last.1;
                z = z * decay + x[i - 1] * (1.0 - decay - ramp) + x[i] * ramp;
            }
            z
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{low_pass, play_from};

    #[test]
    fn play_keeps_its_distance() {
        assert_eq!(play_from(&[0.0, 3.0, 2.5, 0.0], 1.0, 0.0), vec![0.0, 2.0, 2.0, 1.0]);
        // Against the forward side it follows from the first row on.
        assert_eq!(play_from(&[0.0, 0.5, 0.0], 1.0, -1.0), vec![-1.0, -0.5, -0.5]);
    }

    #[test]
    fn low_pass_follows_a_ramp_one_time_constant_behind() {
        let t: Vec<f64> = (0..400).map(|i| i as f64 * 0.7).collect();
        let z = low_pass(&t, &t, 5.0);
        let last = t.len() - 1;
        // Analytic: t − τ (1 − exp(−t/τ)); the ramp is followed exactly, so only rounding is allowed for.
        assert!((z[last] - (t[last] - 5.0 * (1.0 - (-t[last] / 5.0).exp()))).abs() < 1e-9);
    }
}
