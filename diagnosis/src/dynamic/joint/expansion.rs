//! What two recordings say of a model about some parameters, and the parameters that both together prefer.

use numerics::{Symmetric, dot, parallel};

use crate::thresholds::compare::joint::{ENOUGH, PATIENCE};

/// What a recording says of a model about some packed parameters, in units of its noise.
#[derive(Debug, Clone)]
pub struct Expansion {
    /// Sum of the squares that are left.
    pub cost: f64,
    /// Half of how fast that falls along each parameter.
    pub pull: Vec<f64>,
    /// Half of how fast the pull falls.
    pub information: Symmetric,
}

impl Expansion {
    /// To first order, about parameters that are so far off.
    pub fn shifted(&self, by: &[f64]) -> Expansion {
        let n = by.len();
        let through: Vec<f64> =
            (0..n).map(|i| (0..n).map(|j| self.information.at(i, j) * by[j]).sum()).collect();
        let cost = self.cost + dot(by, &through) - 2.0 * dot(by, &self.pull);
        let pull = self.pull.iter().zip(&through).map(|(pull, through)| pull - through).collect();
        Expansion { cost, pull, information: self.information.clone() }
    }

    /// Whether it is of numbers.
    pub fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.pull.iter().chain(&self.information.entries).all(|x| x.is_finite())
    }
}

/// A model evaluated on a recording: its cost, and the expansion on demand, which takes several times as long.
pub struct Evaluation<'a> {
    /// Sum of the squares that are left, in units of the noise, as in [`Expansion`].
    pub cost: f64,
    /// The expansion there; none where it is not finite.
    pub expand: Box<dyn FnOnce() -> Option<Expansion> + Send + 'a>,
}

impl From<Expansion> for Evaluation<'_> {
    fn from(expansion: Expansion) -> Self {
        Evaluation { cost: expansion.cost, expand: Box::new(|| Some(expansion)) }
    }
}

/// By how much which parameters change.
pub type Direction = Vec<(usize, f64)>;

/// The normal equations of the common parameters, then of the lengths of the differences, and their right-hand side: the
/// common ones are in both recordings, the differences in the later one.
pub fn together(about: &[Expansion; 2], differing: &[Direction]) -> (Symmetric, Vec<f64>) {
    let [then, now] = about;
    let n = then.pull.len();
    let common = (0..n).map(|lane| vec![(lane, 1.0)]);
    let unknowns: Vec<Direction> = common.chain(differing.iter().cloned()).collect();
    let information = |a: &Direction, b: &Direction| -> f64 {
        let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
        pairs.map(|((i, a), (j, b))| a * b * now.information.at(*i, *j)).sum()
    };
    let mut normal = Symmetric::zero(unknowns.len());
    for (i, a) in unknowns.iter().enumerate() {
        for (j, b) in unknowns.iter().enumerate() {
            let in_then = if i < n && j < n { then.information.at(i, j) } else { 0.0 };
            *normal.at_mut(i, j) = in_then + information(a, b);
        }
    }
    let pull = |direction: &Direction| direction.iter().map(|(lane, by)| by * now.pull[*lane]).sum::<f64>();
    let right = unknowns.iter().enumerate().map(|(i, a)| pull(a) + if i < n { then.pull[i] } else { 0.0 });
    let right = right.collect();
    (normal, right)
}

/// How far the costs fall, to first order, where some parameters differ.
pub fn promised(about: &[Expansion; 2], differing: &[Direction]) -> f64 {
    let (normal, right) = together(about, differing);
    dot(&right, &normal.factor().solve(&right))
}

/// The parameters of both recordings, and how far each difference goes.
#[derive(Debug, Clone)]
pub struct Point {
    /// The packed parameters of each recording.
    pub packed: [Vec<f64>; 2],
    /// The lengths of the differences.
    pub lengths: Vec<f64>,
}

/// The parameters of both recordings that explain them best, from the best of some starts by Marquardt's method, and what the
/// recordings say about there; none where they can be simulated from no start.
pub fn estimated<'a>(
    starts: &[Point],
    differing: &[Direction],
    evaluate: impl Fn(usize, &[f64]) -> Option<Evaluation<'a>> + Sync,
) -> Option<(Point, [Expansion; 2])> {
    let at = |packed: &[Vec<f64>; 2]| {
        let (then, now) = parallel::join(|| evaluate(0, &packed[0]), || evaluate(1, &packed[1]));
        let (then, now) = (then?, now?);
        let expand = move || {
            let (then, now) = parallel::join(then.expand, now.expand);
            Some([then?, now?])
        };
        Some((then.cost + now.cost, expand))
    };
    let begun = starts.iter().filter_map(|point| Some((point, at(&point.packed)?)));
    let (point, (mut cost, expand)) = begun.min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    let (mut point, mut known) = (point.clone(), expand()?);
    let mut lambda = 0.0;
    for _ in 0..PATIENCE {
        let (normal, right) = together(&known, differing);
        let mut damped = normal.clone();
        (0..right.len()).for_each(|i| *damped.at_mut(i, i) *= 1.0 + lambda);
        let step = damped.factor().solve(&right);
        if dot(&step, &right) < ENOUGH {
            break;
        }
        let (common, lengths) = step.split_at(point.packed[0].len());
        let mut there = point.clone();
        there.packed.iter_mut().for_each(|packed| packed.iter_mut().zip(common).for_each(|(x, by)| *x += by));
        for ((direction, by), length) in differing.iter().zip(lengths).zip(&mut there.lengths) {
            direction.iter().for_each(|(lane, part)| there.packed[1][*lane] += by * part);
            *length += by;
        }
        let better = at(&there.packed).filter(|(next, _)| *next < cost);
        match better.and_then(|(next, expand)| Some((next, expand()?))) {
            Some((next, about)) => {
                let fell = cost - next;
                (point, cost, known) = (there, next, about);
                // Where much is left that is no noise, steps go on to promise a fall that does not come.
                if fell < ENOUGH {
                    break;
                }
                lambda *= 0.1;
            }
            None => lambda = f64::max(10.0 * lambda, 1e-2),
        }
    }
    Some((point, known))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two readings of one parameter with a variance of 1 and of 1/4, at 1 and at 2.
    #[test]
    fn recordings_agree_on_the_weighted_mean_or_differ() {
        let evaluate = |recording: usize, packed: &[f64]| {
            let (at, weight) = [(1.0, 1.0), (2.0, 4.0)][recording];
            let off: f64 = at - packed[0];
            let information = Symmetric { size: 1, entries: vec![weight] };
            Some(Expansion { cost: weight * off * off, pull: vec![weight * off], information }.into())
        };
        let start = |lengths| [Point { packed: [vec![0.0], vec![0.0]], lengths }];
        let (Point { packed: same, .. }, about) = estimated(&start(Vec::new()), &[], evaluate).unwrap();
        assert!((same[0][0] - 1.8).abs() < 1e-12 && same[0] == same[1], "{same:?}");
        // 0.8² + 4·0.2², which one difference explains.
        let own = || vec![vec![(0, 0.5)]];
        assert!((promised(&about, &own()) - 0.8).abs() < 1e-12);
        let (apart, _) = estimated(&start(vec![0.0]), &own(), evaluate).unwrap();
        let [then, now] = [0, 1].map(|recording| apart.packed[recording][0]);
        assert!((then - 1.0).abs() < 1e-9 && (now - 2.0).abs() < 1e-9, "{apart:?}");
        assert!((apart.lengths[0] - 2.0).abs() < 1e-9, "{apart:?}");
    }
}
