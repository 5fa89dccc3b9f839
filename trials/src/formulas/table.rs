//! The formulas of the table of effects, and the ranges in which their nonlinear parameters are sought.

use std::f64::consts::TAU;

use super::Columns;

/// One effect of the table.
pub struct Formula {
    pub id: &'static str,
    /// The effect of which this one is a limiting case: never excluded by a recording that shows this one.
    pub limit_of: Option<&'static str>,
    /// Places from which the search for the nonlinear parameters starts, with the spacing of each.
    pub grid: fn(&Columns) -> Grid,
    /// The columns that the amplitudes multiply, in arcseconds, at nonlinear parameters.
    pub signature: fn(&Columns, &[f64]) -> Vec<Vec<f64>>,
}

impl Formula {
    /// One without nonlinear parameters.
    const fn plain(
        id: &'static str,
        limit_of: Option<&'static str>,
        signature: fn(&Columns, &[f64]) -> Vec<Vec<f64>>,
    ) -> Self {
        Self { id, limit_of, grid: |_| Grid { places: vec![Vec::new()], spacing: Vec::new() }, signature }
    }

    /// One that is a limiting case of no other.
    const fn shaped(
        id: &'static str,
        grid: fn(&Columns) -> Grid,
        signature: fn(&Columns, &[f64]) -> Vec<Vec<f64>>,
    ) -> Self {
        Self { id, limit_of: None, grid, signature }
    }
}

/// Where nonlinear parameters are sought.
pub struct Grid {
    /// The starting places; one empty place where there are no nonlinear parameters.
    pub places: Vec<Vec<f64>>,
    /// The spacing of the places in every parameter.
    pub spacing: Vec<f64>,
}

impl Grid {
    fn line(from: f64, to: f64, count: usize) -> Self {
        let spacing = (to - from) / (count - 1) as f64;
        Self { places: (0..count).map(|i| vec![from + i as f64 * spacing]).collect(), spacing: vec![spacing] }
    }
}

/// The whole table for static recordings.
pub const FORMULAS: &[Formula] = &[
    Formula::plain("thermal_zero_drift", Some("thermal_lag"), |c, _| vec![above_mean(c, &c.temperature_c)]),
    Formula::plain("thermal_gain_drift", None, |c, _| {
        let t = above_mean(c, &c.temperature_c);
        vec![c.theta_arcsec.iter().zip(t).map(|(theta, t)| 1e-6 * theta * t).collect()]
    }),
    Formula::shaped(
        "thermal_lag",
        // ln τ from a few seconds to the length of the recording.
        |c| Grid::line(3f64.ln(), c.duration_s().max(10.0).ln(), 14),
        |c, shape| vec![above_mean(c, &lagged(&c.t_s, &c.temperature_c, shape[0].exp()))],
    ),
    Formula::plain("time_drift", Some("warmup_drift"), |c, _| {
        vec![c.t_s.iter().map(|t| t / 3600.0).collect()]
    }),
    Formula::shaped(
        "warmup_drift",
        // ln τ.
        |c| Grid::line(5f64.ln(), c.duration_s().max(10.0).ln(), 14),
        |c, shape| vec![c.t_s.iter().map(|t| -(-t / shape[0].exp()).exp_m1()).collect()],
    ),
    Formula::shaped(
        "mount_step",
        // The number of the first row after the step.
        |c| Grid::line(1.0, (c.rows() - 1) as f64, (c.rows() - 1).min(104)),
        |c, shape| vec![(0..c.rows()).map(|i| f64::from(u8::from(i as f64 >= shape[0].round()))).collect()],
    ),
    Formula::shaped(
        "backlash",
        // ln of the half width in arcsec; the amplitude is free beside it.
        |_| Grid::line(0.05f64.ln(), 20f64.ln(), 6),
        |c, shape| {
            let radius = shape[0].exp();
            vec![ahead_of_play(&c.true_arcsec, radius).into_iter().map(|a| a / radius).collect()]
        },
    ),
    Formula::plain("hysteresis", None, |c, _| {
        let [low, high] = c.true_arcsec_range;
        let mut sum = vec![0.0; c.rows()];
        for i in 0..40 {
            let radius = 0.5 * (high - low) * (f64::from(i) + 0.5) / 40.0;
            let ahead = ahead_of_play(&c.true_arcsec, radius);
            sum.iter_mut().zip(ahead).for_each(|(s, a)| *s += a / (40.0 * (high - low)));
        }
        vec![sum]
    }),
    Formula::shaped(
        "periodic_error",
        // Periods in the stroke: from three to the half of the readings of a pass, a quarter turn apart.
        |c| {
            let [low, high] = c.true_arcsec_range;
            let most = ((high - low) / (2.2 * spacing(c))).max(4.0);
            Grid::line(3.0, most, (4.0 * (most - 3.0)) as usize + 2)
        },
        |c, shape| {
            let [low, high] = c.true_arcsec_range;
            let turn = |v: &f64| TAU * shape[0] * v / (high - low);
            let of = |f: fn(f64) -> f64| c.true_arcsec.iter().map(|v| f(turn(v))).collect();
            vec![of(f64::sin), of(f64::cos)]
        },
    ),
    Formula::plain("common_mode_leakage", None, |c, _| vec![c.common_um.clone()]),
    Formula::plain("cross_axis_coupling", None, |c, _| vec![c.cross_arcsec.clone()]),
    Formula::plain("coil_crosstalk", None, |c, _| vec![c.coil_a.clone()]),
    Formula::shaped(
        "sensor_clipping",
        // The threshold in parts of the stroke; its sign is the side.
        |_| {
            let side = (0..14).map(|i| 0.4 + 0.04 * f64::from(i));
            let places = side.clone().map(|p| vec![p]).chain(side.map(|p| vec![-p])).collect();
            Grid { places, spacing: vec![0.04] }
        },
        |c, shape| {
            let end = c.theta_end_arcsec;
            let threshold = shape[0].abs().clamp(0.2, 0.99);
            let beyond = |theta: &f64| (theta * shape[0].signum() / end - threshold).max(0.0);
            vec![c.theta_arcsec.iter().map(beyond).collect()]
        },
    ),
    Formula::plain("read_lag", None, |c, _| vec![c.velocity.clone()]),
    Formula::shaped(
        "local_defect",
        // Centre in parts of the stroke, ln of the width in such parts.
        |c| {
            let least = (0.7 * spacing(c) / c.theta_end_arcsec).ln();
            let spacing = [0.03, (0.25f64.ln() - least) / 5.0];
            let places = (-31..=31)
                .flat_map(|i| (0..6).map(move |j| (i, j)))
                .map(|(i, j)| vec![0.03 * f64::from(i), least + f64::from(j) * spacing[1]])
                .collect();
            Grid { places, spacing: spacing.to_vec() }
        },
        |c, shape| {
            let end = c.theta_end_arcsec;
            let width = shape[1].clamp(-6.0, 0.0).exp();
            let bump = |theta: &f64| (-0.5 * ((theta / end - shape[0]) / width).powi(2)).exp();
            vec![c.theta_arcsec.iter().map(bump).collect()]
        },
    ),
];

/// The formula of an id.
pub fn find(id: &str) -> Option<&'static Formula> {
    FORMULAS.iter().find(|f| f.id == id)
}

fn above_mean(c: &Columns, temperature_c: &[f64]) -> Vec<f64> {
    temperature_c.iter().map(|t| t - c.mean_c).collect()
}

/// The usual distance of neighbouring angles in arcseconds, whatever the order in which they were visited.
fn spacing(c: &Columns) -> f64 {
    let mut sorted = c.theta_arcsec.clone();
    sorted.sort_by(f64::total_cmp);
    // Readings at one command differ by arcseconds, commands by hundreds of them.
    let steps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 30.0).collect();
    crate::statistics::percentile(&steps, 0.5).unwrap_or(360.0)
}

/// T_L with τ dT_L/dt = T − T_L, exact for a temperature that runs straight from reading to reading; at the
/// first reading it stands at the temperature.
fn lagged(t_s: &[f64], temperature_c: &[f64], tau_s: f64) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(t_s.len());
    for i in 0..t_s.len() {
        let now = match out.last() {
            None => temperature_c[i],
            Some(last) => {
                let step_s = t_s[i] - t_s[i - 1];
                let behind = if step_s > 0.0 {
                    tau_s * (temperature_c[i] - temperature_c[i - 1]) / step_s
                } else {
                    0.0
                };
                let kept = (-step_s / tau_s).exp();
                temperature_c[i] - behind + (last - temperature_c[i - 1] + behind) * kept
            }
        };
        out.push(now);
    }
    out
}

/// θ − play_r(θ), the play at rest about zero before the first row.
fn ahead_of_play(angle: &[f64], radius: f64) -> Vec<f64> {
    let mut output = 0.0f64;
    angle
        .iter()
        .map(|a| {
            output = output.clamp(a - radius, a + radius);
            a - output
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_catalogued_effect_has_its_formula() {
        for effect in twin::effects::catalogue::ALL.iter().filter(|e| e.catalogued()) {
            assert!(find(effect.id).is_some(), "{}", effect.id);
        }
        assert_eq!(FORMULAS.len(), twin::effects::catalogue::ALL.iter().filter(|e| e.catalogued()).count());
    }

    #[test]
    fn play_lags_by_its_radius() {
        assert_eq!(ahead_of_play(&[-10.0, 0.0, 10.0, 9.5, 0.0], 1.0), [-1.0, 1.0, 1.0, 0.5, -1.0]);
    }
}
