//! The model to and from `plant.toml`.

use faer::Mat;
use faer::linalg::solvers::Solve;
use fitter::plant::{Numbers, Order, Plant, PlantEffect, PlantFile, StateSpace};

use super::looped::Looped;
use super::modal::Modal;
use super::operator::Operator;
use super::subspace::to_blocks;
use crate::dynamic::effects::RAYLEIGH_HYSTERESIS;

/// Id of the effect that carries the loop.
pub const ID: &str = RAYLEIGH_HYSTERESIS;

/// The names of an effect's parameters in the file of a `linear` plant.
pub fn names(id: &str) -> Vec<&'static str> {
    match id {
        ID => vec!["into_state", "into_position", "from_state", "from_drive", "thresholds", "weights"],
        _ => vec!["offset"],
    }
}

/// The plant file of a model; a memoryless loop has no place in it and is left out.
pub fn to_file(model: &Looped, nominal: &Plant) -> PlantFile {
    let lin = &model.linear;
    let (n, m, p) = (lin.order(), lin.inputs, lin.outputs);
    let rows = |values: &[f64], columns: usize| values.chunks_exact(columns).map(<[f64]>::to_vec).collect();
    let mut a = vec![vec![0.0; n]; n];
    for (k, block) in lin.blocks.iter().enumerate() {
        for (i, value) in block.matrix().into_iter().enumerate() {
            a[2 * k + i / 2][2 * k + i % 2] = value;
        }
    }
    let space = StateSpace {
        sample_time_s: lin.step_s,
        a,
        b: rows(&lin.b, m),
        c: (0..p).map(|i| lin.c[i * n..(i + 1) * n].to_vec()).collect(),
        d: rows(&lin.d, m),
    };
    let plant = Plant { order: Some(Order::States(n)), ..nominal.clone() };
    let mut effects = Vec::new();
    if model.loops() > 0 && model.operator.cells() > 0 {
        let operator = &model.operator;
        let parameters = [
            ("into_state", model.e.clone()),
            ("into_position", model.f.clone()),
            ("from_state", model.cz.clone()),
            ("from_drive", model.dz.clone()),
            ("thresholds", operator.thresholds.clone()),
            ("weights", operator.weights()),
        ];
        let parameters = parameters.map(|(name, values)| (name.to_string(), Numbers::Each(values))).into();
        effects.push(PlantEffect { id: ID.to_string(), parameters });
    }
    PlantFile { plant, state_space: Some(space), effects, equations: None }
}

/// The model that a plant file states in full; `None` where it has no matrices, or where they are not those
/// of a stable plant with distinct poles and an even number of states.
pub fn to_model(file: &PlantFile) -> Option<Looped> {
    let space = file.state_space.as_ref()?;
    let (n, m, p) = space.sizes();
    let (blocks, basis) = to_blocks(&Mat::from_fn(n, n, |i, j| space.a[i][j]))?;
    let factor = basis.partial_piv_lu();
    let turned = |columns: usize, value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        let solved = factor.solve(Mat::from_fn(n, columns, value));
        (0..n * columns).map(|i| solved[(i / columns, i % columns)]).collect()
    };
    let seen = |rows: usize, value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        let product = Mat::from_fn(rows, n, value) * &basis;
        (0..rows * n).map(|i| product[(i / n, i % n)]).collect()
    };
    let linear = Modal {
        inputs: m,
        outputs: p,
        step_s: space.sample_time_s,
        blocks,
        b: turned(m, &|i, j| space.b[i][j]),
        c: seen(p, &|i, j| space.c[i][j]),
        d: space.d.concat(),
    };
    let Some(effect) = file.effects.iter().find(|e| e.id == ID) else {
        return Some(Looped::plain(linear));
    };
    let list = |name: &str| match effect.parameters.get(name) {
        Some(Numbers::Each(values)) => Some(values.clone()),
        _ => None,
    };
    let dz = list("from_drive")?;
    let q = dz.len() / m.max(1);
    let (e, f, cz) = (list("into_state")?, list("into_position")?, list("from_state")?);
    let (thresholds, weights) = (list("thresholds")?, list("weights")?);
    let fits = e.len() == n * q && f.len() == p * q && cz.len() == q * n && dz.len() == q * m;
    if !fits || q == 0 || thresholds.len() != weights.len() || thresholds.len() > 32 {
        return None;
    }
    Some(Looped {
        linear,
        e: turned(q, &|i, j| e[i * q + j]),
        f,
        cz: seen(q, &|i, j| cz[i * n + j]),
        dz,
        operator: Operator { thresholds, spacing: weights, exponent: 0.0 },
    })
}
