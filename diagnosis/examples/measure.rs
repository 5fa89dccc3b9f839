//! Measures false alarms, detection and naming of the search on recordings of its own small laboratory:
//! `measure nulls N`, `measure singles N`, `measure pairs N`, `measure outside N`.
mod simulate;
use diagnosis::{dictionary::Kind, effects, explain::explain};
use rayon::prelude::*;
use simulate::{FAMILIES, Lab, rho};
use std::collections::BTreeMap;

const IDS: [&str; 14] = [
    "thermal_zero_drift",
    "thermal_gain_drift",
    "thermal_lag",
    "time_drift",
    "warmup_drift",
    "mount_step",
    "backlash",
    "hysteresis",
    "periodic_error",
    "common_mode_leakage",
    "cross_axis_coupling",
    "coil_crosstalk",
    "sensor_clipping",
    "local_defect",
];
const OUTSIDE: [&str; 7] = [
    "ooc_cross_square",
    "ooc_temperature_square",
    "ooc_time_wave",
    "ooc_time_gain",
    "ooc_common_temperature",
    "ooc_pass_offsets",
    "ooc_direction_tilt",
];

/// What was hidden, what was found, what was hidden one by one, -ln p of the alarm, milliseconds.
type Trial = (String, Vec<String>, Vec<String>, f64, f64);

fn main() {
    let mode = std::env::args().nth(1).unwrap_or("nulls".into());
    let n: u64 = std::env::args().nth(2).and_then(|s| s.parse().ok()).unwrap_or(200);
    let catalogue = effects::catalogue();
    let names = |e: &diagnosis::explain::Explanation| -> Vec<String> {
        let mut v: Vec<String> = e
            .terms
            .iter()
            .map(|t| match &e.search.dictionary.families[t.family].kind {
                Kind::Effect(i) => catalogue[*i].id().to_string(),
                Kind::Generic(p) => {
                    format!("?{}{}", p.variable, p.times.as_ref().map_or(String::new(), |t| format!("*{t}")))
                }
                Kind::Order => "order".into(),
            })
            .collect();
        v.retain(|x| x != "order");
        v.sort();
        v
    };
    let snr: f64 = std::env::args().nth(3).and_then(|s| s.parse().ok()).unwrap_or(8.0);
    for family in FAMILIES {
        let results: Vec<Trial> = (0..n)
            .into_par_iter()
            .map(|k| {
                let mut lab = Lab::new(k * 4 + family as u64 + 77_000);
                let (schedule, temperature) = (lab.pick(3), lab.pick(2));
                let schedule = if std::env::var("SMALL").is_ok() { schedule % 2 } else { schedule };
                let mut rows = lab.schedule(schedule, temperature);
                let (noise, phi, sigma) = lab.noise(&rows, family);
                let mut truth: Vec<String> = Vec::new();
                let mut z: Vec<Vec<f64>> = Vec::new();
                let count = match mode.as_str() {
                    "nulls" => 0,
                    "pairs" => 2,
                    _ => 1,
                };
                while z.len() < count {
                    let id = if mode == "outside" { OUTSIDE[lab.pick(7)] } else { IDS[lab.pick(14)] };
                    if truth.iter().any(|t| t == id) {
                        continue;
                    }
                    z.push(lab.effect(&rows, id));
                    truth.push(id.into());
                }
                for j in 0..count {
                    let others: Vec<Vec<f64>> =
                        (0..count).filter(|i| *i != j).map(|i| z[i].clone()).collect();
                    let now = rho(&rows, &z[j], &others, phi, &sigma);
                    let scale = snr / now;
                    z[j].iter_mut().for_each(|v| *v *= scale);
                }
                for i in 0..rows.len() {
                    let add: f64 = z.iter().map(|z| z[i]).sum();
                    rows.error[i] += add + noise[i];
                    rows.truth[i] = rows.theta[i] - rows.error[i];
                }
                let start = std::time::Instant::now();
                let e = explain(&rows, &catalogue, &[]);
                let took = start.elapsed().as_secs_f64() * 1e3;
                truth.sort();
                (
                    truth.join("+"),
                    names(&e),
                    truth,
                    e.alarm.as_ref().map_or(0.0, |a| e.search.family_wise(a)),
                    took,
                )
            })
            .collect();
        let total = results.len() as f64;
        let detected = results.iter().filter(|r| !r.1.is_empty()).count() as f64;
        let exact = results.iter().filter(|r| r.1 == r.2).count() as f64;
        let times: f64 = results.iter().map(|r| r.4).sum::<f64>() / total;
        println!(
            "{family:?}: n {total} detected {:.2} % exact {:.2} % mean {times:.0} ms",
            100.0 * detected / total,
            100.0 * exact / total
        );
        if mode == "nulls" {
            for level in [0.2, 0.1, 0.05, 0.02, 0.01, 0.005] {
                print!(
                    "  p<{level}: {:.4}",
                    results.iter().filter(|r| r.3 > -f64::ln(level)).count() as f64 / total
                );
            }
            println!();
        }
        let mut confusions: BTreeMap<(String, String), usize> = BTreeMap::new();
        for r in results.iter().filter(|r| r.1 != r.2) {
            *confusions.entry((r.0.clone(), r.1.join("+"))).or_default() += 1;
        }
        let mut c: Vec<_> = confusions.into_iter().collect();
        c.sort_by_key(|c| std::cmp::Reverse(c.1));
        for ((a, b), k) in c.iter().take(14) {
            println!("    {a} -> {b}: {k}");
        }
    }
}
