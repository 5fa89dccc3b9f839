//! Units that depart from the others: each against the median of the fleet and its spread by the median deviation, so that
//! departing units do not hide each other.

use numerics::median;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::thresholds::fleet::{FEWEST_TO_DEPART_FROM, HALVINGS, MEDIAN_FREEDOM, NORMAL_QUARTILE};

use super::Estimate;

/// How far a unit stands from the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Outlying {
    /// Its distance from the fleet's median in standard deviations: spread of the fleet and error of the estimate.
    pub z: f64,
    /// Probability of one unit so far out where none departs; not yet of all units and parameters that were looked at.
    pub p_value: f64,
}

/// How far each unit stands from the median of its lot (`lot`, from 0 up), by the spread in all lots; nothing where there
/// are too few.
pub fn outlying(estimates: &[Estimate], lot: &[usize]) -> Vec<Outlying> {
    let count = estimates.len();
    let mut left = vec![0.0; count];
    let lots = lot.iter().max().map_or(0, |last| last + 1);
    for of in 0..lots {
        let members: Vec<usize> = (0..count).filter(|i| lot[*i] == of).collect();
        let mut values: Vec<f64> = members.iter().map(|i| estimates[*i].value).collect();
        let middle = median(&mut values);
        members.iter().for_each(|i| left[*i] = estimates[*i].value - middle);
    }
    if count < FEWEST_TO_DEPART_FROM + lots.saturating_sub(1) {
        return Vec::new();
    }
    let scaled = |i: usize, variance: f64| left[i].abs() / (estimates[i].error.powi(2) + variance).sqrt();
    let middle = |variance: f64| median(&mut (0..count).map(|i| scaled(i, variance)).collect::<Vec<f64>>());
    let largest = left.iter().fold(0.0, |largest: f64, l| largest.max(l.abs()));
    let (mut low, mut high) = (0.0, (largest / NORMAL_QUARTILE).powi(2));
    if middle(0.0) > NORMAL_QUARTILE {
        for _ in 0..HALVINGS {
            let half = 0.5 * (low + high);
            if middle(half) > NORMAL_QUARTILE { low = half } else { high = half }
        }
    }
    let variance = low;
    let freedom = MEDIAN_FREEDOM * (count as f64 - lots as f64);
    let one = |i: usize| {
        let z = scaled(i, variance) * left[i].signum();
        let p_value = StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |t| (2.0 * t.sf(z.abs())).min(1.0));
        Outlying { z, p_value }
    };
    (0..count).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_that_depart_do_not_hide_each_other_and_lots_do_not_count() {
        let wave = |i: usize| ((i * 7919 % 101) as f64 / 50.0 - 1.0) + 30.0 * (i % 2) as f64;
        let estimate = |i| Estimate { value: if i % 10 == 3 { 60.0 } else { wave(i) }, error: 0.1 };
        let (all, lot): (Vec<Estimate>, Vec<usize>) = (0..40).map(|i| (estimate(i), i % 2)).unzip();
        let far: Vec<usize> = (0..40).filter(|i| outlying(&all, &lot)[*i].p_value < 1e-4).collect();
        assert_eq!(far, [3, 13, 23, 33]);
        assert!(outlying(&all[..5], &lot[..5]).is_empty());
    }
}
