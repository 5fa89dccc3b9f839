//! Every effect does something, and does it in proportion.

use fitter::plant::{Hold, PlantEffect};

use super::catalogue::ALL;
use super::*;
use crate::model::{Model, REST};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

fn excited() -> (Model, Vec<f64>) {
    let model = Model {
        damping: 40.0,
        stiffness: 4e4,
        gains: vec![4e8],
        effects: Vec::new(),
        hold: Hold::BandLimited,
        context: Context { feedback: false },
    };
    let tone = |k: i32, hz: f64, phase: f64| (std::f64::consts::TAU * hz * 5e-4 * f64::from(k) + phase).sin();
    let drive = (0..3000)
        .map(|k| 0.05 * (tone(k, 7.0, 0.0) + tone(k, 23.0, 1.0) + tone(k, 41.0, 2.0) + tone(k, 77.0, 3.0)))
        .collect();
    (model, drive)
}

/// What a recording of this seed draws its device from.
fn device(seed: u64) -> ChaCha12Rng {
    let mut random = ChaCha12Rng::seed_from_u64(seed);
    random.set_stream(1);
    random
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|v| v * v).sum::<f64>() / count).sqrt()
}

#[test]
fn each_shows_by_about_its_strength_and_more_where_it_is_stronger() {
    let (model, drive) = excited();
    let drives = [drive];
    let typical = Typical::of(&model, &drives, 5e-4);
    let bare = model.simulate(&drives, 5e-4, REST).unwrap();
    let size = rms(bare.iter().copied());
    for specification in ALL {
        let shows = |strength: f64| {
            let drawn = (specification.draw)(strength, &typical, &mut device(3));
            let effect = PlantEffect::new(specification.id, &drawn);
            let with = model.with(vec![effect]).unwrap().simulate(&drives, 5e-4, REST).unwrap();
            rms(with.iter().zip(&bare).map(|(a, b)| a - b)) / size
        };
        let (weak, strong) = (shows(0.02), shows(0.08));
        assert!(weak > 1e-4 && weak < 0.5, "{}: {weak}", specification.id);
        assert!(strong > 1.5 * weak, "{}: {weak} {strong}", specification.id);
    }
}

#[test]
fn all_of_the_table_act_together() {
    let (model, drive) = excited();
    let drives = [drive];
    let typical = Typical::of(&model, &drives, 5e-4);
    let effects: Vec<PlantEffect> = ALL
        .iter()
        .filter(|s| s.catalogued())
        .map(|s| PlantEffect::new(s.id, &(s.draw)(0.02, &typical, &mut device(4))))
        .collect();
    assert_eq!(effects.len(), 19);
    let position = model.with(effects).unwrap().simulate(&drives, 5e-4, REST).unwrap();
    assert!(position.iter().all(|x| x.is_finite()));
}

#[test]
fn what_does_not_fit_is_refused() {
    let (model, _) = excited();
    let refused = |effect: PlantEffect| model.with(vec![effect]).unwrap_err().to_string();
    assert!(refused(PlantEffect::new("coulomb", &[])).contains("coulomb_friction"));
    assert!(refused(PlantEffect::new("coulomb_friction", &[("level", 1.0)])).contains("force_per_inertia"));
    assert!(refused(PlantEffect::new("coulomb_friction", &[])).contains("needs"));
    assert!(refused(PlantEffect::new("drive_lag", &[("time_constant_s", -1.0)])).contains("-1"));
}
