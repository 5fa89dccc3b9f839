//! A small laboratory of its own: recordings with known noise and known disturbances, in the rows that a
//! diagnosis sees. It measures false alarms and detection in seconds; it shares no code with the effects.

use diagnosis::linear::{Basis, dot};
use diagnosis::rows::Rows;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Family {
    White,
    Autocorrelated,
    Heteroscedastic,
    Outliers,
}
pub const FAMILIES: [Family; 4] =
    [Family::White, Family::Autocorrelated, Family::Heteroscedastic, Family::Outliers];

pub struct Lab {
    pub rng: ChaCha8Rng,
}

impl Lab {
    pub fn new(seed: u64) -> Lab {
        Lab { rng: ChaCha8Rng::seed_from_u64(seed) }
    }
    pub fn uniform(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.rng.random::<f64>()
    }
    pub fn normal(&mut self) -> f64 {
        let u: f64 = self.rng.random::<f64>().max(1e-300);
        let v: f64 = self.rng.random();
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
    pub fn pick(&mut self, n: usize) -> usize {
        (self.rng.next_u64() % n as u64) as usize
    }

    /// A recording without noise and effects: schedule 0 paper, 1 coarse, 2 fine; temperature 0 lab, 1 chamber, 2 ramp.
    pub fn schedule(&mut self, schedule: usize, temperature: usize) -> Rows {
        let (step, passes) = [(0.1, 6), (0.2, 12), (0.05, 8)][schedule];
        let points = (3.4_f64 / step + 1e-9) as usize + 1;
        let mut r = Rows { unit: "arcsec".into(), pair: true, ..Rows::default() };
        let mut t = 0.0;
        let (mut cm, mut cross) = (0.0, 0.0);
        let coupling = self.uniform(-1.0, 1.0);
        let slope = self.uniform(-1.5, 1.5);
        let (mut tt, mut cc, mut co, mut cr, mut cmd) = (vec![], vec![], vec![], vec![], vec![]);
        let period = self.uniform(500.0, 1400.0);
        let phase = self.uniform(0.0, std::f64::consts::TAU);
        for p in 0..passes {
            if p > 0 {
                t += self.uniform(28.0, 33.0);
            }
            let pass_cm = 0.3 * self.normal();
            let pass_cross = self.normal();
            for k in 0..points {
                t += self.uniform(2.5, 3.5);
                let forward = p % 2 == 0;
                let a = if forward { -1.7 + step * k as f64 } else { 1.7 - step * k as f64 };
                let jitter = 7e-5 * self.normal();
                let theta = (a + jitter) * 3600.0;
                cm = 0.9 * cm + 0.05 * self.normal();
                cross = 0.8 * cross + 0.3 * self.normal();
                let temp = match temperature {
                    0 => 27.0 + 0.8 * (std::f64::consts::TAU * t / 240.0 + phase).sin(),
                    1 => 28.0 + 12.5 * (std::f64::consts::TAU * t / period + phase).sin(),
                    _ => 24.0 + 6.0 * t / 1900.0,
                } + 0.02 * self.normal();
                let s = 12.0 * (theta / 206264.806247_f64).tan();
                r.t_s.push(t);
                r.pass.push(p as i64);
                r.direction.push(if forward { 1.0 } else { -1.0 });
                r.reading.push(s);
                r.weight.push(12.0 / (s * s + 144.0));
                r.theta.push(theta);
                tt.push(temp);
                cc.push(cm + pass_cm + 0.02 * self.normal());
                co.push(0.065 * a * (1.0 + 0.004 * (temp - 27.0)) + 0.008 * self.normal() + 0.002 * pass_cm);
                cr.push(slope * a + cross + pass_cross * 0.7 + coupling * pass_cm + 0.1 * self.normal());
                cmd.push(a);
            }
        }
        r.temperature_c = Some(tt);
        r.common_mode_um = Some(cc);
        r.coil_a = Some(co);
        r.cross_arcsec = Some(cr);
        r.command_deg = Some(cmd);
        // The base: a polynomial of order 9 in x.
        let coefficients: Vec<f64> = (0..10)
            .map(|k| self.normal() * [50.0, 900.0, 30.0, 60.0, 10.0, 20.0, 5.0, 8.0, 2.0, 3.0][k])
            .collect();
        let x: Vec<f64> = r.theta.iter().map(|t| t / 6120.0).collect();
        r.error = x.iter().map(|x| coefficients.iter().rev().fold(0.0, |s, c| s * x + c)).collect();
        r.truth = r.theta.iter().zip(&r.error).map(|(t, e)| t - e).collect();
        r
    }

    /// Noise of one family with σ about 0.7, and its true whitening parameters (φ, σ per row).
    pub fn noise(&mut self, rows: &Rows, family: Family) -> (Vec<f64>, f64, Vec<f64>) {
        let n = rows.len();
        let s = 0.7;
        match family {
            Family::White => ((0..n).map(|_| s * self.normal()).collect(), 0.0, vec![s; n]),
            Family::Autocorrelated => {
                let phi = self.uniform(0.3, 0.75);
                let mut z = self.normal();
                (
                    (0..n)
                        .map(|_| {
                            z = phi * z + (1.0 - phi * phi).sqrt() * self.normal();
                            s * z
                        })
                        .collect(),
                    phi,
                    vec![s; n],
                )
            }
            Family::Heteroscedastic => {
                let low = self.uniform(0.25, 0.6);
                let sigma: Vec<f64> =
                    rows.theta.iter().map(|t| s * (low + (1.0 - low) * 1.3 * (t / 6120.0).abs())).collect();
                (sigma.iter().map(|s| s * self.normal()).collect(), 0.0, sigma)
            }
            Family::Outliers => {
                let size = self.uniform(4.0, 9.0);
                let part = self.uniform(0.01, 0.05);
                let level = s * (1.0 + part * (size * size - 1.0)).sqrt();
                (
                    (0..n)
                        .map(|_| {
                            let k = if self.uniform(0.0, 1.0) < part { size } else { 1.0 };
                            s * k * self.normal()
                        })
                        .collect(),
                    0.0,
                    vec![level; n],
                )
            }
        }
    }

    /// A catalogued effect with unit size: id, contribution.
    pub fn effect(&mut self, rows: &Rows, id: &str) -> Vec<f64> {
        let n = rows.len();
        let t = &rows.t_s;
        let th = &rows.theta;
        let sign = if self.uniform(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let temp = rows.temperature_c.as_ref().unwrap();
        let mean = temp.iter().sum::<f64>() / n as f64;
        let v: Vec<f64> = match id {
            "thermal_zero_drift" => temp.iter().map(|x| x - mean).collect(),
            "thermal_gain_drift" => temp.iter().zip(th).map(|(x, a)| (x - mean) * a * 1e-4).collect(),
            "thermal_lag" => {
                let tau = self.uniform(60.0, 300.0);
                let mut z = temp[0];
                (0..n)
                    .map(|i| {
                        if i > 0 {
                            let h = t[i] - t[i - 1];
                            z += (temp[i] - z) * (1.0 - (-h / tau).exp());
                        }
                        z - mean
                    })
                    .collect()
            }
            "time_drift" => t.to_vec(),
            "warmup_drift" => {
                let tau = self.uniform(0.08, 0.3) * t[n - 1];
                t.iter().map(|t| 1.0 - (-t / tau).exp()).collect()
            }
            "mount_step" => {
                let k = (self.uniform(0.2, 0.8) * n as f64) as usize;
                (0..n).map(|i| if i >= k { 1.0 } else { 0.0 }).collect()
            }
            "backlash" => {
                let mut p = th[0];
                th.iter()
                    .map(|x| {
                        p = p.clamp(x - 0.4, x + 0.4);
                        x - p
                    })
                    .collect()
            }
            "hysteresis" => (0..n).map(|i| rows.direction[i] * (1.0 - (th[i] / 6120.0).powi(2))).collect(),
            "periodic_error" => {
                let p = 12240.0 / self.uniform(4.0, 8.0);
                let f = self.uniform(0.0, std::f64::consts::TAU);
                rows.truth.iter().map(|a| (std::f64::consts::TAU * a / p + f).sin()).collect()
            }
            "common_mode_leakage" => rows.common_mode_um.clone().unwrap(),
            "cross_axis_coupling" => rows.cross_arcsec.clone().unwrap(),
            "coil_crosstalk" => rows.coil_a.clone().unwrap(),
            "sensor_clipping" => {
                let c = self.uniform(0.6, 0.85) * 6120.0;
                let side: f64 = if self.uniform(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
                let v: Vec<f64> = th.iter().map(|a| -side * (side * a - c).max(0.0)).collect();
                return v;
            }
            "local_defect" => {
                let c = self.uniform(-0.8, 0.8) * 6120.0;
                let w = self.uniform(0.06, 0.15) * 3600.0;
                th.iter().map(|a| (-0.5 * ((a - c) / w).powi(2)).exp()).collect()
            }
            // Outside the catalogue.
            "ooc_cross_square" => rows.cross_arcsec.as_ref().unwrap().iter().map(|c| c * c).collect(),
            "ooc_temperature_square" => temp.iter().map(|x| (x - mean).powi(2)).collect(),
            "ooc_time_wave" => {
                let p = self.uniform(90.0, 300.0);
                t.iter().map(|t| (std::f64::consts::TAU * t / p).sin()).collect()
            }
            "ooc_time_gain" => t.iter().zip(th).map(|(t, a)| (t - 0.5 * t) * a).collect(),
            "ooc_common_temperature" => {
                rows.common_mode_um.as_ref().unwrap().iter().zip(temp).map(|(c, x)| c * (x - mean)).collect()
            }
            "ooc_pass_offsets" => {
                let m: Vec<f64> = (0..20).map(|_| self.normal()).collect();
                rows.pass.iter().map(|p| m[*p as usize]).collect()
            }
            "ooc_direction_tilt" => rows.direction.iter().zip(th).map(|(d, a)| d * a).collect(),
            _ => panic!("{id}"),
        };
        v.iter().map(|x| sign * if id == "backlash" || id == "hysteresis" { sign * x } else { *x }).collect()
    }
}

/// ρ of a contribution: its length in the true metric after projecting off order 9 and the other effects.
pub fn rho(rows: &Rows, z: &[f64], others: &[Vec<f64>], phi: f64, sigma: &[f64]) -> f64 {
    let whiten =
        |v: &[f64]| -> Vec<f64> {
            let c = (1.0 - phi * phi).sqrt();
            (0..v.len())
                .map(|i| {
                    if i == 0 {
                        v[0] / sigma[0]
                    } else {
                        (v[i] / sigma[i] - phi * v[i - 1] / sigma[i - 1]) / c
                    }
                })
                .collect()
        };
    let mut b = Basis::new(z.len());
    for c in diagnosis::base::base_columns(rows, 9) {
        b.add(&whiten(&c));
    }
    for o in others {
        b.add(&whiten(o));
    }
    let mut w = whiten(z);
    b.project_off(&mut w);
    dot(&w, &w).sqrt()
}
