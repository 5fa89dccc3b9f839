//! The reading of a sensor that turns as the way that it travelled, without the jumps at the end of the turn.

use std::borrow::Cow;

use super::arc::wrapped;

/// A wrapping reading may exceed the turn by so much of it: the noise of a reading at its end.
const BEYOND: f64 = 0.02;

/// Whether readings look like those of a sensor that starts again at the end of the turn: they lie within one turn
/// from 0, or from half a turn below. Others count their turns and never jump.
fn wraps(measured: &[f64], turn: f64) -> bool {
    let (low, high) = measured
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| (low.min(*m), high.max(*m)));
    let from = |start: f64| low >= start - BEYOND * turn && high <= start + (1.0 + BEYOND) * turn;
    high - low <= (1.0 + BEYOND) * turn && (from(0.0) || from(-0.5 * turn))
}

/// Whether the readings start again at the end of the turn somewhere.
pub(super) fn jumps(measured: &[f64], turn: f64) -> bool {
    measured.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 0.5 * turn) && wraps(measured, turn)
}

/// The readings row by row without wraps: the first as it was read, every other on the turn that is nearest to the
/// row before. Readings that count their turns stay as they are.
pub(crate) fn travelled(measured: &[f64], turn: f64) -> Cow<'_, [f64]> {
    if !jumps(measured, turn) {
        return Cow::Borrowed(measured);
    }
    let mut turns = 0.0;
    let mut before = measured[0];
    (measured.iter())
        .map(|m| {
            turns -= ((m - before) / turn).round();
            before = *m;
            m + turns * turn
        })
        .collect()
}

/// The same about a place: of a recording of one turn, or a part, whole turns are taken off or added so that its middle
/// lies nearest to `place`. Where a wrapping reading started to count is chance.
pub(crate) fn travelled_about(measured: &[f64], turn: f64, place: f64) -> Cow<'_, [f64]> {
    let readings = travelled(measured, turn);
    let (low, high) = ends(&readings);
    let shift = turn * ((place - 0.5 * (low + high)) / turn).round();
    if shift == 0.0 || !shift.is_finite() || high - low > MOST * turn || !wraps(measured, turn) {
        return readings;
    }
    readings.iter().map(|m| m + shift).collect()
}

/// So many turns count as one: calibrations run a little over its end.
const MOST: f64 = 1.1;

/// The place in whose distance an error that grows over the turn is counted: the middle of the recorded turn, of several
/// that of the first.
pub(super) fn middle_of_first_turn(travelled: &[f64], turn: f64) -> f64 {
    let (low, high) = ends(travelled);
    if high - low > MOST * turn { low + 0.5 * turn } else { 0.5 * (low + high) }
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Values, each on the turn nearest to a place: for what stands at one place of the turn.
pub(crate) fn nearest(values: &[f64], turn: f64, place: f64) -> Vec<f64> {
    values.iter().map(|value| place + wrapped(value - place, turn)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrap_is_no_jump() {
        assert_eq!(travelled(&[350.0, 359.0, 8.0, 20.0], 360.0)[..], [350.0, 359.0, 368.0, 380.0]);
        assert_eq!(travelled(&[8.0, 359.0, 350.0, 359.0, 8.0], 360.0)[..], [8.0, -1.0, -10.0, -1.0, 8.0]);
        // Noise below zero at the beginning of the turn.
        assert_eq!(travelled(&[-0.02, 359.99, 0.01], 360.0)[..], [-0.02, -0.009999999999990905, 0.01]);
        // Turns are counted: the move back is a move.
        assert_eq!(travelled(&[0.0, 500.0, 0.0], 360.0)[..], [0.0, 500.0, 0.0]);
    }

    #[test]
    fn the_turn_on_which_it_began_does_not_matter() {
        let (forward, backward) = ([90.0, 200.0, 310.0, 60.0, 85.0], [85.0, 60.0, 310.0, 200.0, 90.0]);
        let mut turned = travelled_about(&backward, 360.0, 268.0).to_vec();
        turned.reverse();
        assert_eq!(turned, travelled_about(&forward, 360.0, 268.0)[..]);
        assert_eq!(turned, [90.0, 200.0, 310.0, 420.0, 445.0]);
        assert_eq!(travelled_about(&[10.0, 80.0], 360.0, 270.0)[..], [370.0, 440.0]);
        assert_eq!(travelled_about(&[3610.0, 3680.0], 360.0, 270.0)[..], [3610.0, 3680.0]);
        assert_eq!(nearest(&[359.0, 721.0, 10.0], 360.0, 2.0), [-1.0, 1.0, 10.0]);
        assert_eq!(middle_of_first_turn(&[0.0, 3600.0], 360.0), 180.0);
    }
}
