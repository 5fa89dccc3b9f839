//! A constant part of the positions: an offset of the sensors, or of the drives, which for a plant that holds
//! its position are one.

use std::ops::Range;

use fitter::plant::{Numbers, PlantEffect, PlantFile};
use numerics::{mean, mean_and_error};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::diagnose::rms;
use super::plan::Plan;
use crate::dynamic::DynamicRecording;
use crate::dynamic::effects::{DRIVE_OFFSET, SENSOR_OFFSET};
use crate::thresholds::dynamic::linear::offset::{BLOCKS, CHANCE, LEAST_PART};
use crate::verdict::{NamedEffect, Parameter};

/// Id of the effect.
pub const ID: &str = SENSOR_OFFSET;

/// An offset of every position, in position units.
#[derive(Debug, Clone)]
pub struct Offset {
    values: Vec<f64>,
    errors: Vec<f64>,
    chance: f64,
    part: f64,
}

/// The offset beside predicted positions; none where it is not worth its name.
pub fn offset(recording: &DynamicRecording, predicted: &[Vec<f64>], plan: &Plan) -> Option<Offset> {
    let blocks: Vec<Range<usize>> = plan.fitted().iter().flat_map(parts).collect();
    let student = StudentsT::new(0.0, 1.0, blocks.len() as f64 - 1.0).ok()?;
    let (mut values, mut errors, mut chance) = (Vec::new(), Vec::new(), 1.0f64);
    for (recorded, predicted) in recording.positions.iter().zip(predicted) {
        let mean_of = |rows: &Range<usize>| -> f64 {
            let apart: Vec<f64> =
                rows.clone().filter(|k| recording.scored(*k)).map(|k| recorded[k] - predicted[k]).collect();
            mean(&apart)
        };
        let means: Vec<f64> = blocks.iter().map(mean_of).collect();
        let (value, error) = mean_and_error(&means);
        let t = value.abs() / error.max(f64::MIN_POSITIVE);
        chance = chance.min(2.0 * student.sf(t) * recording.positions.len() as f64);
        values.push(value);
        errors.push(error);
    }
    let held = plan.held();
    let rows = if held.is_empty() { recording.runs.clone() } else { held };
    let mut offset = Offset { values, errors, chance, part: 0.0 };
    let before = rms(recording, predicted, &rows);
    let mut moved = predicted.to_vec();
    offset.add_to(&mut moved);
    offset.part = 1.0 - (rms(recording, &moved, &rows) / before.max(f64::MIN_POSITIVE)).powi(2);
    (chance < CHANCE && offset.part > LEAST_PART).then_some(offset)
}

/// Equal parts of some rows.
fn parts(rows: &Range<usize>) -> Vec<Range<usize>> {
    let length = (rows.len() / BLOCKS).max(1);
    (0..BLOCKS).map(|k| rows.start + k * length..(rows.start + (k + 1) * length).min(rows.end)).collect()
}

impl Offset {
    /// What a plant file states; none where it states none.
    pub fn stated(plant: &PlantFile, positions: usize) -> Option<Offset> {
        let effect = plant.effects.iter().find(|e| e.id == ID)?;
        let given = effect.parameters.get("offset")?;
        let values = (0..positions).map(|k| given.get(k)).collect::<Option<Vec<f64>>>()?;
        Some(Offset { errors: vec![0.0; positions], values, chance: 1.0, part: 0.0 })
    }

    /// The sum of two.
    pub fn and(&self, other: Option<&Offset>) -> Offset {
        let mut sum = self.clone();
        if let Some(other) = other {
            sum.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
        }
        sum
    }

    /// Adds it to predicted positions.
    pub fn add_to(&self, predicted: &mut [Vec<f64>]) {
        for (column, value) in predicted.iter_mut().zip(&self.values) {
            column.iter_mut().for_each(|x| *x += value);
        }
    }

    /// The effect in `plant.toml`.
    pub fn effect(&self) -> PlantEffect {
        let offset = match self.values.as_slice() {
            [one] => Numbers::One(*one),
            several => Numbers::Each(several.to_vec()),
        };
        PlantEffect { id: ID.into(), parameters: [("offset".to_string(), offset)].into() }
    }

    /// What is said of it; `drives` of the plant move every position where there are as many.
    pub fn named(&self, unit: &str, drives: usize) -> NamedEffect {
        let several = self.values.len() > 1;
        let parameter = |(k, (value, error)): (usize, (&f64, &f64))| {
            let name = if several { format!("offset_{}", k + 1) } else { "offset".into() };
            Parameter::normal(&name, *value, *error, unit)
        };
        NamedEffect {
            id: ID.into(),
            kind: crate::verdict::CATALOGUED,
            title: "Offset of the read-out".into(),
            formula: String::new(),
            p_value: self.chance.max(1e-300),
            share: self.part.clamp(0.0, 1.0),
            parameters: self.values.iter().zip(&self.errors).enumerate().map(parameter).collect(),
            alternatives: if self.values.len() <= drives { vec![DRIVE_OFFSET.into()] } else { Vec::new() },
            runtime_correctable: true,
            form: crate::verdict::Form::default(),
        }
    }
}
