//! The curve of detection against strength: a normal ogive Φ((ρ − c)/w) by maximum likelihood, the shape
//! that an ideal detector has with w = 1, and the isotonic estimate, which supposes no shape.

use serde::Serialize;

use crate::statistics::{lower_limit, phi, quantile, upper_limit};

/// One trial: the strength, and whether something was reported.
pub type Point = (f64, bool);

#[derive(Debug, Clone, Serialize)]
pub struct Curve {
    /// c: ρ at which half of the effects are detected.
    pub half: f64,
    /// w: how much ρ rises from there to the 84 % point; 1 for an ideal detector.
    pub width: f64,
    /// The false-alarm rate at which the ideal detector is compared.
    pub false_alarm: f64,
    /// Largest of the shifts in ρ from the ideal curve at 50 % and at 90 % detection.
    pub shift: f64,
    /// Shares in bins of ρ.
    pub bins: Vec<Bin>,
    /// The isotonic estimate: steps (from ρ on, share).
    pub isotonic: Vec<(f64, f64)>,
}

/// Detections among the effects of a range of strength.
#[derive(Debug, Clone, Serialize)]
pub struct Bin {
    pub from: f64,
    pub to: f64,
    pub hits: u64,
    pub of: u64,
    /// 95 % interval of the share (Clopper–Pearson).
    pub limits: [f64; 2],
}

/// The curve of the points; none where they do not determine one (all or none detected, or too few).
pub fn fit(points: &[Point], false_alarm: f64) -> Option<Curve> {
    let hits = points.iter().filter(|p| p.1).count();
    if points.len() < 10 || hits == 0 || hits == points.len() {
        return None;
    }
    let (half, width) = ogive(points);
    let threshold = quantile(1.0 - 0.5 * false_alarm);
    let ninety = quantile(0.9);
    let shift = (half - threshold).max(half + ninety * width - threshold - ninety);
    Some(Curve { half, width, false_alarm, shift, bins: bins(points), isotonic: isotonic(points) })
}

/// c and w by a search that halves its steps.
fn ogive(points: &[Point]) -> (f64, f64) {
    let loss = |c: f64, log_w: f64| -> f64 {
        let w = log_w.exp();
        points
            .iter()
            .map(|&(rho, hit)| {
                let p = phi((rho - c) / w).clamp(1e-9, 1.0 - 1e-9);
                -(if hit { p } else { 1.0 - p }).ln()
            })
            .sum()
    };
    let (mut c, mut log_w) = (4.0, 0.0);
    let mut best = loss(c, log_w);
    let mut step = 2.0;
    while step > 1e-5 {
        let mut moved = false;
        for (dc, dw) in [(step, 0.0), (-step, 0.0), (0.0, 0.5 * step), (0.0, -0.5 * step)] {
            // Wider than from 1/50 to 50 nothing that was measured can tell.
            let (tried_c, tried_w) = (c + dc, (log_w + dw).clamp(-3.9, 3.9));
            let tried = loss(tried_c, tried_w);
            if tried < best {
                (best, c, log_w, moved) = (tried, tried_c, tried_w, true);
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    (c, log_w.exp())
}

fn bins(points: &[Point]) -> Vec<Bin> {
    let edges = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 12.0, 20.0, 1e9];
    let mut out = Vec::new();
    for pair in edges.windows(2) {
        let inside: Vec<&Point> = points.iter().filter(|p| p.0 >= pair[0] && p.0 < pair[1]).collect();
        let (of, hits) = (inside.len() as u64, inside.iter().filter(|p| p.1).count() as u64);
        if of > 0 {
            let limits = [lower_limit(hits, of, 0.975), upper_limit(hits, of, 0.975)];
            out.push(Bin { from: pair[0], to: pair[1], hits, of, limits });
        }
    }
    out
}

/// The non-decreasing step function nearest to the points (pool adjacent violators).
fn isotonic(points: &[Point]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // From ρ, hits, count.
    let mut blocks: Vec<(f64, f64, f64)> = Vec::new();
    for (rho, hit) in sorted {
        blocks.push((rho, f64::from(u8::from(hit)), 1.0));
        while let [.., a, b] = blocks[..] {
            if a.1 / a.2 < b.1 / b.2 {
                break;
            }
            blocks.truncate(blocks.len() - 2);
            blocks.push((a.0, a.1 + b.1, a.2 + b.2));
        }
    }
    blocks.into_iter().map(|(rho, hits, count)| (rho, hits / count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::rand_core::SeedableRng;

    /// Points of a detector that needs `shift` more than the ideal one at 1 %.
    fn points(shift: f64) -> Vec<Point> {
        let mut generator = rand_chacha::ChaCha12Rng::seed_from_u64(5);
        let threshold = quantile(0.995) + shift;
        (0..4000)
            .map(|i| {
                let rho = 8.0 * f64::from(i) / 4000.0;
                (rho, generator.random::<f64>() < phi(rho - threshold))
            })
            .collect()
    }

    #[test]
    fn the_ideal_detector_has_no_shift_and_a_worse_one_has_its_own() {
        for shift in [0.0, 0.7, 2.0] {
            let curve = fit(&points(shift), 0.01).unwrap();
            // The standard error of c from 4000 trials over 8 is about 0.05; at 90 % twice that.
            assert!((curve.shift - shift).abs() < 0.2, "{} for {shift}", curve.shift);
            assert!((curve.width - 1.0).abs() < 0.15);
        }
    }

    #[test]
    fn isotonic_steps_rise() {
        let steps = isotonic(&points(1.0));
        assert!(steps.windows(2).all(|s| s[0].0 < s[1].0 && s[0].1 < s[1].1));
        assert!(steps.last().unwrap().1 > 0.99);
    }

    #[test]
    fn nothing_detected_is_no_curve() {
        assert!(fit(&[(1.0, false); 50], 0.01).is_none());
    }
}
