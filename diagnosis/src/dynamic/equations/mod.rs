//! Diagnosis of what is simulated by a plant in equations: which effects of the catalogue, or of the user's own, it lacks.

mod catalogue;
mod diagnose;
mod forms;
pub mod model;
mod search;
pub mod second_order;
pub mod start;
pub mod verdict;

use std::sync::Arc;

use fitter::plant::equations::EffectText;
use fitter::plant::{Kind, PlantFile};
pub use motion::equations::MotionEffect;
use motion::equations::{EquationsError, Plant};

pub use catalogue::entries;
pub use diagnose::diagnose;
pub use forms::described;

/// Reads a user's effects in motion for a plant in equations, or for a second-order one as equations; `file` is their
/// file's name in messages. None where the plant is of another kind.
///
/// # Errors
/// [`EquationsError`], also where an id is one of the catalogue's, or stands twice.
pub fn own(
    file: &str,
    texts: &[EffectText],
    plant_file: &str,
    plant: &PlantFile,
) -> Option<Result<Vec<Arc<MotionEffect>>, EquationsError>> {
    match plant.plant.kind {
        Kind::Equations => Some(read(file, texts, plant_file, plant)),
        Kind::SecondOrder if !texts.is_empty() => Some(beside_second_order(file, texts, plant_file, plant)),
        Kind::SecondOrder | Kind::Linear => None,
    }
}

fn beside_second_order(
    file: &str,
    texts: &[EffectText],
    plant_file: &str,
    plant: &PlantFile,
) -> Result<Vec<Arc<MotionEffect>>, EquationsError> {
    // Names and units alone count here.
    let in_equations = second_order::in_equations(plant_file, plant, [1.0; 3])?;
    // Units of the plant that are none were refused just now.
    let text = |text: &EffectText| plant.effect_in_equations(text).unwrap_or_else(|_| text.clone());
    read(file, &texts.iter().map(text).collect::<Vec<_>>(), plant_file, &in_equations)
}

fn read(
    file: &str,
    texts: &[EffectText],
    plant_file: &str,
    plant: &PlantFile,
) -> Result<Vec<Arc<MotionEffect>>, EquationsError> {
    let Some(plant) = Plant::of(plant_file, plant) else { return Ok(Vec::new()) };
    let plant = plant?;
    let mut taken: Vec<String> = entries().into_iter().map(|entry| entry.id).collect();
    let read = |text: &EffectText| {
        if taken.contains(&text.id) {
            let key = format!("effect `{}`, `id`", text.id);
            let what = "there is an effect of this id: give another".into();
            return Err(EquationsError::Key { file: file.into(), key, what });
        }
        taken.push(text.id.clone());
        plant.effect(file, text).map(Arc::new)
    };
    texts.iter().map(read).collect()
}
