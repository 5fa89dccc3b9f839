//! Return-point memory: the extremes of an input that a hysteresis of nested loops still remembers. A move
//! beyond an earlier extreme wipes out the loop that closes there (Madelung 1905; Mayergoyz, Mathematical
//! Models of Hysteresis (1991), section 1.2), so that the response is a sum over the few extremes left.

use physics::number::Number;

/// What Rayleigh's material remembers: the extremes left, the present input last, each with the response
/// R there: u |u| from rest on, and half a squared move, with its sign, from each extreme to the next.
#[derive(Debug, Clone)]
pub struct Turns<T> {
    extremes: Vec<(T, T)>,
}

impl<T: Number> Default for Turns<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Number> Turns<T> {
    /// At rest, at no input.
    pub fn new() -> Turns<T> {
        Turns { extremes: Vec::with_capacity(32) }
    }

    /// The input moves to `u` without turning on the way; the response there.
    pub fn to(&mut self, u: T) -> T {
        let value = |x: &(T, T)| x.0.value();
        if let [.., before, last] = self.extremes.as_slice() {
            // On along the same branch, or round.
            if (u.value() - value(last)) * (value(last) - value(before)) >= 0.0 {
                self.extremes.pop();
            }
        }
        // What is passed is forgotten, and the loop that closes there with it.
        while let [.., before, last] = self.extremes.as_slice() {
            let up = u.value() > value(last);
            if up != (value(before) > value(last)) || up != (u.value() >= value(before)) {
                break;
            }
            self.extremes.truncate(self.extremes.len() - 2);
        }
        if let [only] = self.extremes.as_slice()
            && u.value().abs() >= value(only).abs()
        {
            self.extremes.clear();
        }
        let response = match self.extremes.last() {
            None => u * u.abs(),
            Some((from, there)) => *there + (u - *from) * (u - *from).abs() * 0.5,
        };
        self.extremes.push((u, response));
        response
    }

    /// The inputs that are remembered, the widest first.
    pub fn inputs(&self) -> impl Iterator<Item = f64> + '_ {
        self.extremes.iter().map(|(u, _)| u.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::number::Dual;

    fn walk() -> impl Iterator<Item = f64> {
        let mut state = 7u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            3.0 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        })
    }

    /// Rayleigh's material is a continuum of plays of equal density: R = 2 ∫ play_r(u) dr.
    #[test]
    fn a_continuum_of_plays_responds_alike() {
        let step = 1e-4;
        let mut plays = vec![0.0f64; 20_000];
        let mut turns = Turns::<f64>::new();
        for u in walk().take(60) {
            for (index, play) in plays.iter_mut().enumerate() {
                let r = step * (index as f64 + 0.5);
                *play = play.clamp(u - r, u + r);
            }
            let sum: f64 = 2.0 * step * plays.iter().sum::<f64>();
            assert!((turns.to(u) - sum).abs() < 1e-6);
        }
    }

    #[test]
    fn small_steps_along_the_way_change_nothing_and_what_is_remembered_is_enough() {
        let (mut large, mut small) = (Turns::<f64>::new(), Turns::<f64>::new());
        let mut at = 0.0;
        for u in walk().take(200) {
            (1..=10).for_each(|k| {
                small.to(at + (u - at) * k as f64 / 10.0);
            });
            at = u;
            let response = large.to(u);
            assert!((small.to(u) - response).abs() < 1e-12);
            let mut again = Turns::<f64>::new();
            let last = large.inputs().fold(0.0, |_, input| again.to(input));
            assert!((last - response).abs() < 1e-12);
        }
    }

    #[test]
    fn slopes_follow_an_offset_of_the_input() {
        let response = |offset: f64| {
            let mut turns = Turns::<f64>::new();
            walk().take(40).fold(0.0, |_, u| turns.to(u + offset))
        };
        let mut turns = Turns::<Dual<1>>::new();
        let zero = Dual::<1>::from_f64(0.0);
        let dual = walk().take(40).fold(zero, |_, u| turns.to(Dual::variable(0.1, 0) + Dual::from_f64(u)));
        let quotient = (response(0.1 + 1e-6) - response(0.1 - 1e-6)) / 2e-6;
        assert!((dual.slopes[0] - quotient).abs() < 1e-6, "{} {quotient}", dual.slopes[0]);
    }
}
