//! The best way round a ring of nodes, each with a few candidates: the one whose costliest link is the cheapest.

/// Chooses one candidate at every node. `candidates` says how many there are at each; `cost` is that of the link from
/// node i, with its candidate, to the next, the last being linked to the first. Returns the choice and its costliest
/// link.
pub fn ring(candidates: &[usize], cost: impl Fn(usize, usize, usize) -> f64) -> (Vec<usize>, f64) {
    let nodes = candidates.len();
    let next = |node: usize| (node + 1) % nodes;
    let links: Vec<Vec<f64>> = (0..nodes)
        .map(|node| {
            let pairs = (0..candidates[node]).flat_map(|a| (0..candidates[next(node)]).map(move |b| (a, b)));
            pairs.map(|(a, b)| cost(node, a, b)).collect()
        })
        .collect();
    let mut best = (vec![0; nodes], f64::INFINITY);
    for first in 0..candidates[0] {
        // The costliest link on the best way from `first` to each candidate, and where that way came from.
        let mut reached = vec![f64::INFINITY; candidates[0]];
        reached[first] = 0.0;
        let mut from = Vec::with_capacity(nodes);
        for node in 0..nodes {
            let width = candidates[next(node)];
            let (mut following, mut came) = (vec![f64::INFINITY; width], vec![0; width]);
            for (a, so_far) in reached.iter().enumerate() {
                for b in 0..width {
                    let costliest = so_far.max(links[node][a * width + b]);
                    if costliest < following[b] {
                        (following[b], came[b]) = (costliest, a);
                    }
                }
            }
            reached = following;
            from.push(came);
        }
        if reached[first] < best.1 {
            let mut choice = vec![first; nodes];
            for node in (1..nodes).rev() {
                choice[node] = from[node][choice[next(node)]];
            }
            best = (choice, reached[first]);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against all choices there are.
        #[test]
        fn no_choice_is_better(costs in prop::collection::vec(0.0..1.0f64, 4 * 9)) {
            let cost = |node: usize, a: usize, b: usize| costs[9 * node + 3 * a + b];
            let (choice, costliest) = ring(&[3; 4], cost);
            let of = |c: &[usize]| (0..4).map(|i| cost(i, c[i], c[(i + 1) % 4])).fold(0.0, f64::max);
            prop_assert_eq!(of(&choice), costliest);
            for all in 0..81usize {
                let other = [all % 3, all / 3 % 3, all / 9 % 3, all / 27];
                prop_assert!(of(&other) >= costliest);
            }
        }
    }
}
