//! Pairs of recordings of one mechanism in motion: driven otherwise, with other noise.

use fitter::plant::PlantEffect;
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::dynamic::effects::find;
use twin::dynamic::{Bench, bench};

use super::{CAME_BY, Kind, MOVED_BY, Pair};
use crate::dynamic::draw::{LEAST_RHO, drawn_effect};
use crate::dynamic::nearest_effect::{Scene, positions};
use crate::dynamic::plan::{Assignment, Circumstances, circumstances};
use crate::dynamic::truth::{Group, distinguishable};
use crate::linear::norm;

const PLANT: &str = include_str!("../dynamic/plant.toml");
/// Part by which an effect is weakened to see what its growth adds.
const GROWTH: f64 = 1e-3;
/// Part by which the strength of a new effect may miss the wanted one: not everything is proportional to it.
const MISSED: f64 = 0.1;

/// One of the recordings.
struct Side {
    bench: Bench,
    seed: u64,
}

/// Draws a pair; none where the effect does not show in both recordings, or one of them cannot be simulated.
pub(super) fn pair(kind: Kind, number: usize, generator: &mut ChaCha12Rng) -> Option<Pair> {
    // Of the pairs in which nothing changes every other has an effect.
    let group = if kind == Kind::Same && number.is_multiple_of(2) { Group::Null } else { Group::Single };
    let number = if kind == Kind::Same { number / 2 } else { number };
    let assignment = Assignment { group, number, seed: 0 };
    let Circumstances { ids, strengths, bench: then, .. } = circumstances(&assignment, generator);
    let other = circumstances(&assignment, generator).bench;
    // The same mechanism, with the same sensor and the same amplifier.
    let now = Bench {
        model: then.model.clone(),
        drive_a: then.drive_a,
        noise_arcsec: then.noise_arcsec,
        noise: then.noise,
        ..other
    };
    let mut side = |bench| Side { bench, seed: generator.random() };
    let sides = [side(then), side(now)];
    let shape = generator.clone();
    let typical = sides[0].bench.typical(sides[0].seed);
    let effect = |strength: f64| -> Option<PlantEffect> {
        Some(drawn_effect(find(ids.first()?)?, strength, &typical, &mut shape.clone()))
    };
    // ρ of the effect in a recording, of one that moves as it grows from there, and whether the recording can tell it from every other where that is asked.
    let seen = |side: &Side, strength: f64, asked: bool| -> Option<(f64, bool)> {
        let effects = [effect(strength)?];
        let with = side.bench.with_effects(effects.to_vec()).ok()?;
        let clean = positions(&with, side.seed)?;
        let scene = Scene::new(&side.bench, &with, side.seed, &effects, &clean, &typical)?;
        let growth = || scene.growth(vec![effect((1.0 - GROWTH) * strength)?], GROWTH);
        let added = if kind == Kind::Moved { growth()? } else { scene.white(0).to_vec() };
        let rest = scene.beside(0).projected_off(&added);
        let rho = norm(&rest);
        let tells = || distinguishable(scene.closest(0, &rest, &mut shape.clone()).as_ref(), rho);
        Some((rho, asked && tells()))
    };
    let (mut amounts, mut can_tell) = ([None, None], false);
    if let Some(strength) = strengths.first().copied() {
        let had = kind == Kind::Moved;
        let ((before, then_tells), (after, _)) =
            (seen(&sides[0], strength, had)?, seen(&sides[1], strength, false)?);
        let joint_error = (before.powi(-2) + after.powi(-2)).sqrt();
        let moved = MOVED_BY * joint_error;
        let (then, now) = match kind {
            Kind::Same => (Some(strength), strength),
            Kind::Moved if moved < 0.8 && generator.random() => (Some(strength), strength * (1.0 - moved)),
            Kind::Moved => (Some(strength), strength * (1.0 + moved)),
            Kind::Came => (None, strength * CAME_BY * joint_error),
        };
        if kind != Kind::Came && before < LEAST_RHO {
            return None;
        }
        let (last, now_tells) = seen(&sides[1], now, kind != Kind::Same && !then_tells)?;
        if (last / (after * now / strength) - 1.0).abs() > MISSED {
            return None;
        }
        amounts = [then, Some(now)];
        can_tell = then_tells || now_tells;
    }
    let record = |side: &Side, strength: Option<f64>| {
        let effects: Vec<PlantEffect> = strength.and_then(effect).into_iter().collect();
        let series = side.bench.with_effects(effects).ok()?.record(side.seed).ok()?;
        let mut csv = Vec::new();
        series.write_csv(Some(bench::DECIMALS), &mut csv).ok()?;
        String::from_utf8(csv).ok()
    };
    Some(Pair {
        then: record(&sides[0], amounts[0])?,
        now: record(&sides[1], amounts[1])?,
        nominal: PLANT.into(),
        id: ids.first().map(|id| (*id).to_string()).filter(|_| kind != Kind::Same),
        can_tell,
    })
}
