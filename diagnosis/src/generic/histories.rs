//! Memories of where the angle has been, none of them an effect of the catalogue: loops, what dies away from a turning
//! point, states that follow the direction, and what remains of an extreme.

use crate::effects::play_from;
use crate::rows::Rows;

/// What the history of the scaled angle `x` may leave: loops, what dies away from a turning point, states that
/// follow the direction, and what remains of an extreme.
pub(super) fn histories(rows: &Rows, x: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let memory = [0.1, 0.3, 0.6].map(|r| {
        let p = play_from(x, r, x.first().copied().unwrap_or(0.0));
        x.iter().zip(&p).map(|(x, p)| x - p).collect::<Vec<f64>>()
    });
    let mut groups = vec![memory.to_vec()];
    for length in [0.1, 0.18, 0.3, 0.42, 0.6] {
        groups.push(vec![since_turning(rows, x, length, false)]);
        groups.push(vec![since_turning(rows, x, length, true)]);
    }
    for length in [0.03, 0.1, 0.25, 0.6] {
        groups.push(vec![following_direction(rows, x, length)]);
    }
    let turning = remembered_turning(x, 0.02);
    for extreme in [turning.clone(), last_beyond(x, 0.7), last_beyond(x, 0.85)] {
        for length in [0.2, 0.4, 0.8] {
            let trace = |(x, m): (&f64, &f64)| m * (-(x - m).abs() / length).exp();
            groups.push(vec![x.iter().zip(&extreme).map(trace).collect()]);
        }
        groups.push(vec![extreme]);
    }
    for part in [0.25, 0.8] {
        groups.push(vec![fading(&rows.t_s, &turning, part)]);
    }
    groups
}

/// The last place before each row that was beyond `least` of half the stroke, nothing before the first.
fn last_beyond(x: &[f64], least: f64) -> Vec<f64> {
    let mut last = 0.0;
    let before = |x: &f64| if x.abs() > least { std::mem::replace(&mut last, *x) } else { last };
    x.iter().map(before).collect()
}

/// A memory that fades with the time since it last changed, with a time constant that is a part of the mean time
/// between two changes.
fn fading(t_s: &[f64], memory: &[f64], part: f64) -> Vec<f64> {
    let changes = memory.windows(2).filter(|m| m[0] != m[1]).count();
    let time_constant = part * (t_s[t_s.len() - 1] - t_s[0]) / (changes + 1) as f64;
    let mut since = t_s[0];
    (0..t_s.len())
        .map(|i| {
            if i > 0 && memory[i] != memory[i - 1] {
                since = t_s[i - 1];
            }
            memory[i] * (-(t_s[i] - since) / time_constant.max(1e-300)).exp()
        })
        .collect()
}

/// A part that dies away with the travel since the last turning point; `signed` gives it the sign of the
/// direction.
fn since_turning(rows: &Rows, x: &[f64], length: f64, signed: bool) -> Vec<f64> {
    let mut turning = x[0];
    (0..x.len())
        .map(|i| {
            if i > 0 && rows.direction[i] != rows.direction[i - 1] {
                turning = x[i - 1];
            }
            let part = (-(x[i] - turning).abs() / length).exp();
            if signed { part * rows.direction[i] } else { part }
        })
        .collect()
}

/// A state that follows the direction of motion with the travel, from nothing at the first row: the simplest
/// of the rate-independent memories with one state (Duhem).
fn following_direction(rows: &Rows, x: &[f64], length: f64) -> Vec<f64> {
    let mut state = 0.0;
    (0..x.len())
        .map(|i| {
            if i > 0 {
                state += (rows.direction[i] - state) * -(-(x[i] - x[i - 1]).abs() / length).exp_m1();
            }
            state
        })
        .collect()
}

/// The place of the last turning point, nothing before the first: what remains of an extreme once visited. A
/// turn counts when it is left by more than `least`.
fn remembered_turning(x: &[f64], least: f64) -> Vec<f64> {
    let (mut extreme, mut sign, mut memory) = (x[0], 0.0, 0.0);
    let mut out = Vec::with_capacity(x.len());
    for &x in x {
        if sign == 0.0 && (x - extreme).abs() > least {
            sign = (x - extreme).signum();
            extreme = x;
        } else if sign * (x - extreme) > 0.0 {
            extreme = x;
        } else if sign * (extreme - x) > least && sign != 0.0 {
            memory = extreme;
            sign = -sign;
            extreme = x;
        }
        out.push(memory);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{fading, last_beyond, remembered_turning};

    #[test]
    fn an_excursion_is_remembered_from_the_next_row_on() {
        let x = [0.0, 0.8, 0.9, 0.2, -0.75, 0.0, 0.1];
        assert_eq!(last_beyond(&x, 0.7), [0.0, 0.0, 0.8, 0.9, 0.9, -0.75, -0.75]);
    }

    #[test]
    fn a_turning_point_is_remembered_once_it_is_left_and_fades_with_the_time() {
        let x = [-1.0, 0.0, 1.0, 0.99, 0.0, -1.0, 0.0];
        let memory = remembered_turning(&x, 0.02);
        assert_eq!(memory, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, -1.0]);
        let t: Vec<f64> = (0..7).map(|i| 3.0 * f64::from(i)).collect();
        // Two changes in 18 s: 6 s between them on average. A change counts from the row before it.
        let wanted = [0.0, 0.0, 0.0, 0.0, (-0.5_f64).exp(), (-1.0_f64).exp(), -(-0.5_f64).exp()];
        let found = fading(&t, &memory, 1.0);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }
}
