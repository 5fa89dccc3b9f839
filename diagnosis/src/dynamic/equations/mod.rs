//! Diagnosis of what is simulated by a plant in equations: which effects of the catalogue, or of the user's own, it lacks.

mod catalogue;
mod diagnose;
mod model;
mod search;
mod start;
mod verdict;

use std::sync::Arc;

use fitter::plant::PlantFile;
use fitter::plant::equations::EffectText;
pub use motion::equations::MotionEffect;
use motion::equations::{EquationsError, Plant};

pub use catalogue::entries;
pub use diagnose::diagnose;

/// Reads a user's effects in motion for a plant in equations; `file` is their file's name in messages. None where the
/// plant is of another kind.
///
/// # Errors
/// [`EquationsError`], also where an id is one of the catalogue's, or stands twice.
pub fn own(
    file: &str,
    texts: &[EffectText],
    plant_file: &str,
    plant: &PlantFile,
) -> Option<Result<Vec<Arc<MotionEffect>>, EquationsError>> {
    let plant = match Plant::of(plant_file, plant)? {
        Ok(plant) => plant,
        Err(error) => return Some(Err(error)),
    };
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
    Some(texts.iter().map(read).collect())
}
