//! Effects that the fleet shows, each unit's share of them perhaps too weak to be named: sought forward and back, over all units
//! at once, every one beside the others.

use std::collections::{BTreeMap, BTreeSet};

use super::{Estimate, Forced, Pooled, Test, pool};
use crate::thresholds::fleet::{FALSE_ALARMS, FEWEST_UNITS, MOST_SHARED, NEARLY_AS_STRONG};

/// A parameter of an effect, fitted in every unit.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Shared {
    /// Effect, parameter and shape.
    pub test: Test,
    /// Over the units.
    pub pooled: Pooled,
    /// Its family-wise p-value among all effects that were tried, where the fleet shows the effect.
    pub found: Option<f64>,
    /// Effects that would do nearly as well in its place, and add nothing beside it.
    pub alternatives: Vec<String>,
    /// The estimate of every unit; none where its recording does not determine it.
    pub estimates: Vec<Option<Estimate>>,
}

/// An effect at one shape.
type Group = (String, String);

/// The effects that the fleet shows, and after them, not found by the fleet, those that some unit names; each pooled beside
/// those that the fleet shows. `named` are the ids that the units name.
pub fn shared(units: &[Forced], named: &BTreeSet<String>) -> Vec<Shared> {
    let fleet = Fleet::of(units);
    let found = fleet.search();
    let shown: Vec<&Group> = found.iter().map(|found| &found.group).collect();
    let mut all = Vec::new();
    for Found { group, p_value, near, .. } in &found {
        let others: Vec<&Group> = shown.iter().filter(|other| **other != group).copied().collect();
        all.extend(fleet.shared(group, &others, Some(*p_value), near));
    }
    for id in named.iter().filter(|id| shown.iter().all(|group| group.0 != **id)) {
        let own = fleet.groups.keys().filter(|group| group.0 == *id);
        let strengths = own.filter_map(|group| Some((group, fleet.strength(group, &shown)?.1)));
        if let Some((group, _)) = strengths.max_by(|a, b| a.1.total_cmp(&b.1)) {
            all.extend(fleet.shared(group, &shown, None, &[]));
        }
    }
    all
}

/// An effect that the fleet shows.
struct Found {
    group: Group,
    /// Family-wise, when it was found, and how many groups were tried then.
    p_value: f64,
    tried: f64,
    /// Effects that would do in its place.
    near: Vec<String>,
}

/// The estimates of other units of the same parameters, each beside the same effects: for every one of `shown` those of every
/// unit.
pub fn of_others(units: &[Forced], shown: &[Shared]) -> Vec<Vec<Option<Estimate>>> {
    let fleet = Fleet::of(units);
    let group = |of: &Shared| (of.test.effect.clone(), of.test.at.clone());
    let found: BTreeSet<Group> = shown.iter().filter(|of| of.found.is_some()).map(group).collect();
    let estimates = |of: &Shared| {
        let own = group(of);
        let others: Vec<&Group> = found.iter().filter(|other| **other != own).collect();
        let mut all = fleet.estimates(&own, &others).into_iter();
        all.find(|(test, _)| **test == of.test).map_or(vec![None; units.len()], |(_, estimates)| estimates)
    };
    shown.iter().map(estimates).collect()
}

/// The units, and which of their tests belong to an effect at one shape.
struct Fleet<'a> {
    units: &'a [Forced],
    /// For every group the tests, and for every unit which of its own they are.
    groups: BTreeMap<Group, (BTreeSet<Test>, Vec<Vec<usize>>)>,
}

impl<'a> Fleet<'a> {
    fn of(units: &'a [Forced]) -> Fleet<'a> {
        let mut groups: BTreeMap<Group, (BTreeSet<Test>, Vec<Vec<usize>>)> = BTreeMap::new();
        for (number, unit) in units.iter().enumerate() {
            for (index, test) in unit.tests.iter().enumerate() {
                let group = groups.entry((test.effect.clone(), test.at.clone())).or_default();
                group.1.resize(units.len(), Vec::new());
                group.0.insert(test.clone());
                group.1[number].push(index);
            }
        }
        Fleet { units, groups }
    }

    /// The effects that the fleet shows: forward, and back again.
    fn search(&self) -> Vec<Found> {
        let mut found: Vec<Found> = Vec::new();
        // An effect that was dropped may return: the steps are counted.
        for _ in 0..2 * MOST_SHARED {
            let next = if found.len() < MOST_SHARED { self.strongest(&found) } else { None };
            let Some(next) = next else { break };
            found.push(next);
            self.drop_needless(&mut found);
        }
        found
    }

    /// The strongest effect beside those found, where it is significant.
    fn strongest(&self, found: &[Found]) -> Option<Found> {
        let taken: Vec<&Group> = found.iter().map(|found| &found.group).collect();
        let tried: Vec<(&Group, f64, f64)> = (self.groups.keys())
            .filter(|group| taken.iter().all(|other| other.0 != group.0))
            .filter_map(|group| self.strength(group, &taken).map(|(p, t)| (group, p, t)))
            .collect();
        let of = tried.len() as f64;
        let strongest = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1).then(b.2.total_cmp(&a.2)));
        let (group, p_value, t) = strongest.filter(|(_, p_value, _)| p_value * of < FALSE_ALARMS)?;
        let beside = [&taken[..], &[*group]].concat();
        let near: BTreeSet<String> = (tried.iter())
            .filter(|(other, _, own)| other.0 != group.0 && *own > NEARLY_AS_STRONG * t)
            .filter(|(other, ..)| !self.adds(other, &beside, of))
            .map(|(other, ..)| other.0.clone())
            .collect();
        let near = near.into_iter().collect();
        Some(Found { group: (*group).clone(), p_value: p_value * of, tried: of, near })
    }

    /// Drops what explains nothing beside the effect that was found last: that one is what it stood for.
    fn drop_needless(&self, found: &mut Vec<Found>) {
        let Some(mut last) = found.pop() else { return };
        let mut k = 0;
        while k < found.len() {
            let others: Vec<&Group> = (0..found.len()).filter(|j| *j != k).map(|j| &found[j].group).collect();
            if self.adds(&found[k].group, &[&others[..], &[&last.group]].concat(), last.tried) {
                k += 1;
            } else {
                last.near.push(found.remove(k).group.0);
            }
        }
        found.push(last);
    }

    /// Whether a group is significant beside others, among so many.
    fn adds(&self, group: &Group, others: &[&Group], of: f64) -> bool {
        self.strength(group, others).is_some_and(|(p_value, _)| p_value * of < FALSE_ALARMS)
    }

    /// For every parameter of a group the estimate of every unit, beside the other groups.
    fn estimates(&self, group: &Group, others: &[&Group]) -> Vec<(&Test, Vec<Option<Estimate>>)> {
        let Some((tests, of_units)) = self.groups.get(group) else { return Vec::new() };
        let mut all: Vec<(&Test, Vec<Option<Estimate>>)> =
            tests.iter().map(|test| (test, vec![None; self.units.len()])).collect();
        for (number, unit) in self.units.iter().enumerate() {
            let own = &of_units[number];
            let beside = others.iter().filter_map(|other| self.groups.get(other));
            let beside: Vec<usize> = beside.flat_map(|(_, of)| of[number].iter().copied()).collect();
            for (index, estimate) in own.iter().zip(unit.beside(own, &beside)) {
                let place = all.iter_mut().find(|(test, _)| **test == unit.tests[*index]);
                place.into_iter().for_each(|(_, estimates)| estimates[number] = estimate);
            }
        }
        all
    }

    /// The p-value of a group among its parameters, and the largest |t|; none where too few units determine it.
    fn strength(&self, group: &Group, others: &[&Group]) -> Option<(f64, f64)> {
        let all = self.estimates(group, others);
        let pooled = all.iter().filter_map(|(_, estimates)| of_enough(estimates));
        let strongest = pooled.max_by(|a, b| a.t.abs().total_cmp(&b.t.abs()))?;
        Some((strongest.p_zero * all.len() as f64, strongest.t.abs()))
    }

    fn shared(&self, group: &Group, others: &[&Group], found: Option<f64>, near: &[String]) -> Vec<Shared> {
        let one = |(test, estimates): (&Test, Vec<Option<Estimate>>)| {
            let (test, pooled) = (test.clone(), of_enough(&estimates)?);
            Some(Shared { test, pooled, found, alternatives: near.to_vec(), estimates })
        };
        self.estimates(group, others).into_iter().filter_map(one).collect()
    }
}

fn of_enough(estimates: &[Option<Estimate>]) -> Option<Pooled> {
    let known: Vec<Estimate> = estimates.iter().flatten().copied().collect();
    pool(&known).filter(|_| known.len() >= FEWEST_UNITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units that see three columns, the second nearly the first: what they say is of `truth`, with an error of one of its
    /// standard errors.
    fn units(count: usize, truth: [f64; 3]) -> Vec<Forced> {
        let test = |effect: &str| Test {
            effect: effect.into(),
            at: String::new(),
            parameter: "k".into(),
            unit: "arcsec".into(),
        };
        let products = [[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let noise = |k: usize| {
            let uniform =
                ((k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / (1u64 << 53) as f64;
            3f64.sqrt() * (2.0 * uniform - 1.0)
        };
        let one = |unit: usize| {
            let e: [f64; 3] = std::array::from_fn(|k| noise(3 * unit + k));
            // By the Cholesky factor of the products, which are the covariance of the scores.
            let e = [e[0], 0.8 * e[0] + 0.6 * e[1], e[2]];
            let score = |k: usize| (0..3).map(|j| products[k][j] * truth[j]).sum::<f64>() + e[k];
            Forced {
                tests: ["a", "b", "c"].map(test).to_vec().into(),
                terms: Vec::new(),
                scores: (0..3).map(score).collect(),
                information: vec![1.0, 0.8, 0.0, 1.0, 0.0, 1.0],
            }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn the_fleet_finds_what_no_unit_can_and_nothing_where_there_is_nothing() {
        let none = BTreeSet::new();
        let found = shared(&units(200, [1.0, 0.0, 0.0]), &none);
        assert_eq!(found.iter().map(|f| f.test.effect.as_str()).collect::<Vec<_>>(), ["a"]);
        assert!((found[0].pooled.mean - 1.0).abs() < 0.2 && found[0].found.is_some_and(|p| p < 1e-6));
        let both = shared(&units(200, [1.0, 0.0, -0.7]), &none);
        let ids: BTreeSet<&str> = both.iter().map(|f| f.test.effect.as_str()).collect();
        assert_eq!(ids, BTreeSet::from(["a", "c"]));
        assert!(shared(&units(200, [0.0; 3]), &none).is_empty());
        // The second column, which stood for the first until it was found, is no more than an alternative.
        assert!(found[0].alternatives.iter().all(|other| other == "b"));
        let named = shared(&units(200, [0.0; 3]), &BTreeSet::from(["c".to_string()]));
        assert!(named.len() == 1 && named[0].found.is_none() && named[0].pooled.mean.abs() < 0.3);
    }

    #[test]
    fn what_a_unit_names_stands_beside_other_effects_and_not_beside_itself() {
        let mut unit = units(1, [1.0, 0.0, 0.0]).remove(0);
        let alone = unit.beside(&[0], &[])[0].unwrap();
        assert!((alone.error - 1.0).abs() < 1e-12);
        // A term that is the second column.
        unit.terms = vec!["b".into()];
        unit.scores.push(unit.scores[1]);
        unit.information = vec![1.0, 0.8, 0.0, 0.8, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
        assert!((unit.beside(&[0], &[])[0].unwrap().error - 1.0 / 0.6).abs() < 1e-9);
        assert!((unit.beside(&[1], &[])[0].unwrap().error - 1.0).abs() < 1e-12);
        // Where the fleet shows what the unit names, the unit's own column stands for it.
        assert_eq!(unit.beside(&[2], &[1]), unit.beside(&[2], &[]));
    }
}
