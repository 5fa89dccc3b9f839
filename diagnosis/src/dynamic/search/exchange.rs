//! Exchanging what was found: an effect for one that it is easily taken for, and terms that others have driven to where
//! they are no physics.

use super::{Augmented, LEAST_GAIN, MOST_EXCHANGES, Search, gain};
use crate::dynamic::data::{CHOOSE, CHOOSE_ROWS, FIT_ROWS};
use crate::dynamic::estimate::Fitted;
use crate::dynamic::model::{Model, Term};
use crate::thresholds::dynamic::search::exchange::{CLOSE, STRONG};

impl Search<'_> {
    /// The model without terms that all rows together drive to where they are no physics, with what they are easily taken
    /// for in their place, or with one delay or lag in that of another, where that does better then.
    pub fn settled(&self, chosen: Fitted) -> Fitted {
        let mut chosen = chosen;
        for _ in 0..MOST_EXCHANGES {
            let all = self.complete(&chosen);
            let Some(k) =
                (self.given..all.model.terms.len()).find(|k| !Model::sound(&all.model.terms[*k], self.data))
            else {
                break;
            };
            let Some(shorter) = self.fit(&chosen.model.without(k), &chosen.states) else { break };
            let shorter = self.best_hold(shorter, FIT_ROWS);
            let mut others = self.near(&shorter, |t, _| t.effect.is_late());
            others.extend(self.worthy(&shorter, self.instead_of(&chosen, k, &shorter)));
            chosen = others
                .into_iter()
                .map(|f| self.best_hold(f, FIT_ROWS))
                .fold(shorter, |best, f| if f.costs[CHOOSE] < best.costs[CHOOSE] { f } else { best });
        }
        chosen
    }

    /// A better model in place of one with delays or lags, or with terms that others have driven to where they are no physics
    /// (a delay before its cause, friction that is less at rest): with what such a term is easily taken for in its place, or
    /// without it, the drive running otherwise between the samples. To first order delay, lag and that are one; which was
    /// taken was decided beside less, and a later term may be there only to mend it.
    pub(super) fn exchanged(&self, present: &Fitted) -> Option<Fitted> {
        let terms = &present.model.terms[self.given..];
        let sound = |t: &Term| Model::sound(t, self.data);
        let doubtful = |t: &Term| t.effect.is_late() || !sound(t);
        let unsound = !terms.iter().all(sound);
        if !terms.iter().any(doubtful) {
            return None;
        }
        let mut others: Vec<Fitted> = self
            .near(present, |t, _| doubtful(t))
            .into_iter()
            .map(|f| self.pruned(self.best_hold(f, FIT_ROWS)))
            .collect();
        others.extend((0..terms.len()).filter(|k| doubtful(&terms[*k])).filter_map(|k| {
            let shorter = self.fit(&present.model.without(self.given + k), &present.states)?;
            Some(self.best_hold(shorter, FIT_ROWS))
        }));
        let better = |f: &Fitted| {
            let fewer = present.model.free() as f64 - f.model.free() as f64;
            let lost = gain(f, present, CHOOSE_ROWS);
            let close = f.costs[CHOOSE] < CLOSE * present.costs[CHOOSE];
            let simpler = fewer > 0.0 && lost < 2.0 + 4.0 * fewer;
            let nearer = fewer >= 0.0 && lost < -LEAST_GAIN && gain(f, present, FIT_ROWS) < -LEAST_GAIN;
            f.model.terms[self.given..].iter().all(sound) && (simpler || nearer || (unsound && close))
        };
        others.retain(better);
        others.into_iter().min_by(|a, b| {
            let merit = |f: &Fitted| gain(f, present, CHOOSE_ROWS) + 4.0 * f.model.free() as f64;
            merit(a).total_cmp(&merit(b))
        })
    }

    /// Models in which one weak term is replaced by an effect that it is easily taken for, and which do
    /// nearly as well on these windows: more rows have to decide.
    pub fn rivals(&self, chosen: &Fitted) -> Vec<Model> {
        self.near(chosen, |_, growth| growth <= STRONG).into_iter().map(|f| f.model).collect()
    }

    /// Models in which one term is replaced, fitted: one for which `may` holds, given the factor by which the squared
    /// residual grows without it.
    fn near(&self, chosen: &Fitted, may: impl Fn(&Term, f64) -> bool) -> Vec<Fitted> {
        let mut near = Vec::new();
        for k in self.given..chosen.model.terms.len() {
            let Some(without) = self.fit(&chosen.model.without(k), &chosen.states) else { continue };
            if !may(&chosen.model.terms[k], without.costs[CHOOSE] / chosen.costs[CHOOSE]) {
                continue;
            }
            let others = self.instead_of(chosen, k, &without).into_iter();
            near.extend(others.filter(|f| f.costs[CHOOSE] < CLOSE * chosen.costs[CHOOSE]));
        }
        near
    }

    /// What term `k` is easily taken for, in its place.
    fn instead_of(&self, chosen: &Fitted, k: usize, without: &Fitted) -> Vec<Fitted> {
        let ids = chosen.model.terms[k].effect.confused_with;
        let catalogue = self.catalogue.iter().copied().filter(|e| ids.contains(&e.id)).collect();
        Search { data: self.data, catalogue, given: self.given }.in_place_of(chosen, k, without)
    }
}

#[cfg(test)]
mod tests {
    use fitter::plant::Hold;

    use super::*;
    use crate::dynamic::DynamicRecording;
    use crate::dynamic::data::{ALL, Data};
    use crate::dynamic::effects::effect;
    use crate::dynamic::estimate::Simulated;

    const ROWS: usize = 4096;
    const NOISE: f64 = 1.0;
    /// Resonance at 32 Hz, sampled at 1 kHz.
    const NOMINAL: [f64; 3] = [40.0, 4e4, 4e8];

    /// A recording of a mechanism along a random drive, which keeps its value for eight samples.
    fn recorded(truth: &Model) -> DynamicRecording {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let values: Vec<f64> = (0..ROWS / 8).map(|_| random()).collect();
        let drive: Vec<f64> = (0..ROWS).map(|k| values[k / 8]).collect();
        // A simulation may run as far.
        let mut recording = DynamicRecording::made(1e-3, drive, vec![1e6; ROWS]);
        let clean = truth.positions(&[[0.0; 2]], &Data::new(&recording)).unwrap();
        recording.positions = vec![clean.iter().map(|x| x + NOISE * 12f64.sqrt() * random()).collect()];
        recording
    }

    fn term(id: &str, parameters: &[f64]) -> Term {
        Term::new(effect(id).unwrap(), parameters.to_vec())
    }

    fn ids(fitted: &Fitted) -> Vec<&str> {
        fitted.model.terms.iter().map(|t| t.effect.id).collect()
    }

    #[test]
    fn friction_that_is_no_physics_gives_way_to_what_it_was_taken_for() {
        let friction = 3e7;
        let plain = Model::nominal(NOMINAL, Hold::ZeroOrder);
        let recording = recorded(&plain.with(term("coulomb_friction", &[friction, 1.0])));
        let data = Data::new(&recording);
        let search = Search::new(&data, &[], 0);
        // Its speed lies where no mechanism moves.
        let mut stribeck = term("stribeck_friction", &[friction, 0.0, 1e30, 1.0, 2.0]);
        stribeck.free = vec![true, false, false, false, false];
        assert!(!Model::sound(&stribeck, &data));
        let chosen = search.fit(&plain.with(stribeck), &data.first_states()).unwrap();
        let settled = search.settled(chosen);
        assert_eq!(ids(&settled), ["coulomb_friction"]);
        assert!(settled.rms(ALL) < 1.05 * NOISE, "{}", settled.rms(ALL));
    }

    #[test]
    fn a_resonance_far_below_that_of_the_mechanism_is_found() {
        let plain = Model::nominal(NOMINAL, Hold::ZeroOrder);
        let recording = recorded(&plain.with(term("flexible_mode", &[6.0, 0.01, 0.01])));
        let data = Data::new(&recording);
        let search = Search::new(&data, &[], 0);
        let found = search.run(&search.fit(&plain, &data.first_states()).unwrap());
        assert_eq!(ids(&found), ["flexible_mode"]);
        let frequency = found.model.terms[0].parameters[0];
        assert!((frequency - 6.0).abs() < 0.01, "{frequency}");
        assert!(found.rms(ALL) < 1.05 * NOISE, "{}", found.rms(ALL));
    }

    #[test]
    fn a_held_drive_makes_a_delay_beside_a_lag_needless() {
        let plain = |hold| Model::nominal(NOMINAL, hold);
        let recording = recorded(&plain(Hold::ZeroOrder).with(term("drive_lag", &[4e-4])));
        let data = Data::new(&recording);
        let search = Search::new(&data, &[], 0);
        let two =
            plain(Hold::FirstOrder).with(term("transport_delay", &[5e-4])).with(term("drive_lag", &[4e-4]));
        let present = search.fit(&two, &data.first_states()).unwrap();
        let exchanged = search.exchanged(&present).unwrap();
        // To this recording a lag of the drive and one of the read-out are the same.
        assert_eq!((exchanged.model.terms.len(), exchanged.model.hold), (1, Hold::ZeroOrder));
        let lag_s = exchanged.model.terms[0].parameters[0];
        assert!((lag_s / 4e-4 - 1.0).abs() < 0.02, "{lag_s}");
    }
}
