//! The direction of motion of every row: as the file says it, or as the readings move.

/// Words for the directions; 1 and −1, and 1 and 0, are numbers.
pub(super) const WORDS: &[(&str, f64)] =
    &[("+", 1.0), ("-", -1.0), ("up", 1.0), ("down", -1.0), ("forward", 1.0), ("backward", -1.0)];

/// The directions as numbers; else the row whose number is none.
pub(super) fn of_numbers(values: &[f64]) -> Result<Vec<i8>, usize> {
    let by_zero = values.iter().all(|value| [0.0, 1.0].contains(value));
    let of = |(row, value): (usize, &f64)| match value {
        1.0 => Ok(1),
        -1.0 => Ok(-1),
        0.0 if by_zero => Ok(-1),
        _ => Err(row),
    };
    values.iter().enumerate().map(of).collect()
}

/// Part of the stroke that the readings must come back for the motion to have turned: what is less is noise, or a
/// sensor that settles.
const TURNED: f64 = 0.02;

/// The directions in which readings move in every pass, those of a sensor that starts anew after a `turn` taken as one
/// movement. The farthest row of a move belongs to it.
pub(super) fn of_motion(readings: impl Iterator<Item = f64>, pass: &[i32], turn: Option<f64>) -> Vec<i8> {
    let mut along: Vec<f64> = readings.collect();
    if let Some(turn) = turn {
        for row in 1..along.len() {
            along[row] -= turn * ((along[row] - along[row - 1]) / turn).round();
        }
    }
    let range = |(low, high): (f64, f64), x: &f64| (low.min(*x), high.max(*x));
    let (low, high) = along.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
    let least = TURNED * (high - low);
    let mut directions = Vec::with_capacity(along.len());
    let mut rest = &along[..];
    for pass in pass.chunk_by(|a, b| a == b) {
        let (readings, others) = rest.split_at(pass.len());
        directions.extend(of_pass(readings, least));
        rest = others;
    }
    directions
}

/// The directions within a pass, whose motion has turned where the readings have come back by `least`.
fn of_pass(along: &[f64], least: f64) -> Vec<i8> {
    let mut directions = vec![1; along.len()];
    // The first row of a move, its lowest and highest so far, and its direction, which is unknown at first.
    let (mut start, mut lowest, mut highest, mut direction) = (0, 0, 0, 0);
    for row in 0..along.len() {
        lowest = if along[row] < along[lowest] { row } else { lowest };
        highest = if along[row] > along[highest] { row } else { highest };
        let (back, forward) = (along[highest] - along[row] > least, along[row] - along[lowest] > least);
        let last = match direction {
            1 if back => highest,
            -1 if forward => lowest,
            0 => {
                direction = i8::from(forward) - i8::from(back);
                continue;
            }
            _ => continue,
        };
        directions[start..=last].fill(direction);
        (start, lowest, highest, direction) = (last + 1, row, row, -direction);
    }
    directions[start..].fill(if direction == 0 { 1 } else { direction });
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_come_and_go_have_directions() {
        let there_and_back = [0.0, 1.0, 2.0, 1.99, 3.0, 4.0, 3.0, 2.0, 2.01, 1.0, 0.0, 1.0];
        let expected = [1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, 1];
        assert_eq!(of_motion(there_and_back.into_iter(), &[1; 12], None), expected);
        assert_eq!(of_motion([4.0, 2.0, 1.0].into_iter(), &[1, 1, 1], None), [-1, -1, -1]);
        // Ten degrees at a time, over zero.
        let turning = [340.0, 350.0, 0.0, 10.0, 0.0, 350.0];
        assert_eq!(of_motion(turning.into_iter(), &[1; 6], Some(360.0)), [1, 1, 1, 1, -1, -1]);
        // Every pass begins anew, where the one before has ended.
        assert_eq!(of_motion([5.0, 6.0, 6.1, 5.0].into_iter(), &[1, 1, 2, 2], None), [1, 1, -1, -1]);
        assert_eq!(of_motion([5.0, 5.0].into_iter(), &[1, 1], None), [1, 1]);
    }

    #[test]
    fn ones_and_zeros_are_directions_where_there_is_nothing_else() {
        assert_eq!(of_numbers(&[1.0, 0.0]), Ok(vec![1, -1]));
        assert_eq!(of_numbers(&[1.0, 0.0, -1.0]), Err(1));
    }
}
