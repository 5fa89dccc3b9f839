//! The catalogue of effects in motion, wherever they fit into a plant in equations.

use std::sync::Arc;

use fitter::plant::equations::{EffectText, Part, PlantParameter, declared};
use motion::equations::{MotionEffect, Plant};
use physics::Unit;

use super::super::data::Data;

/// The catalogue as it is written.
const TEXT: &str = include_str!("catalogue.toml");

/// Which names of a plant the names of the catalogue stand for.
#[derive(Clone, Default)]
struct Binding<'a> {
    /// A state and the state that is its rate.
    momentum: Option<[&'a (String, Unit); 2]>,
    input: Option<&'a (String, Unit)>,
    output: Option<(&'a String, &'a Unit)>,
}

/// The entries of the catalogue.
pub fn entries() -> Vec<EffectText> {
    // The text is a part of the program, and a test reads it.
    declared("catalogue.toml", TEXT).unwrap_or_default()
}

/// Every effect of the catalogue in every place of a plant into which it fits. Where there are several places the id ends
/// in the name of the place.
pub fn effects(plant: &Plant) -> Vec<Arc<MotionEffect>> {
    let momenta: Vec<[&(String, Unit); 2]> = plant
        .states
        .iter()
        .zip(&plant.rates)
        .filter_map(|(x, (rate, _))| Some([x, plant.states.iter().find(|(name, _)| *name == rate.text)?]))
        .collect();
    let none = Binding::default();
    let in_place = |entry: &EffectText| {
        let mut bindings: Vec<Binding> = match entry.equation.is_empty() {
            true => vec![none.clone()],
            false => momenta.iter().map(|pair| Binding { momentum: Some(*pair), ..none.clone() }).collect(),
        };
        if entry.input.contains_key("u") || reads(entry, "u") {
            let inputs = |momentum| plant.inputs.iter().map(move |input| (momentum, input));
            let pairs: Vec<_> = bindings.iter().flat_map(|binding| inputs(binding.momentum)).collect();
            let one = |(momentum, input)| Binding { momentum, input: Some(input), output: None };
            bindings = pairs.into_iter().map(one).collect();
        }
        if !entry.output.is_empty() {
            let output = Some((&plant.output.0, plant.output_unit()));
            bindings.iter_mut().for_each(|binding| binding.output = output);
        }
        let several = bindings.len() > 1;
        let bound = |binding: &Binding| {
            let mut text = bound(entry, binding)?;
            if several {
                let input = binding.input.map(|(name, _)| name);
                let place = binding.momentum.map(|[_, v]| &v.0).or(input)?;
                text.id = format!("{}_{place}", text.id);
            }
            plant.effect("catalogue.toml", &text).ok().map(Arc::new)
        };
        bindings.iter().filter_map(bound).collect::<Vec<_>>()
    };
    entries().iter().flat_map(in_place).collect()
}

/// Whether an effect reads a name.
fn reads(entry: &EffectText, name: &str) -> bool {
    let texts = entry.equation.values().chain(entry.input.values()).chain(entry.output.values());
    texts.filter_map(|text| physics::parse(text).ok()).any(|expression| expression.names().contains(&name))
}

/// An entry in the names and units of a plant.
fn bound(entry: &EffectText, binding: &Binding) -> Option<EffectText> {
    let name = |name: &str| match name {
        "x" => binding.momentum.map(|[x, _]| x.0.clone()),
        "v" => binding.momentum.map(|[_, v]| v.0.clone()),
        "u" => binding.input.map(|(u, _)| u.clone()),
        "y" => binding.output.map(|(y, _)| y.clone()),
        _ => None,
    };
    let place = |map: &std::collections::BTreeMap<String, String>| {
        let one = |(own, text): (&String, &String)| {
            let expression = physics::parse(text).ok()?.renamed(&name);
            Some((name(own)?, expression.to_string()))
        };
        map.iter().map(one).collect::<Option<_>>()
    };
    let position = binding.momentum.map(|[x, _]| &x.1).or(binding.output.map(|(_, unit)| unit));
    let parameter = |(name, parameter): (&String, &PlantParameter)| {
        let mut unit = Unit::parse(&parameter.unit).ok()?;
        for (own, of_plant) in [("p", position), ("q", binding.input.map(|(_, unit)| unit))] {
            if let Some(of_plant) = of_plant {
                unit = unit.with(own, of_plant);
            }
        }
        Some((name.clone(), PlantParameter { unit: unit.to_string(), ..parameter.clone() }))
    };
    Some(EffectText {
        equation: place(&entry.equation)?,
        input: place(&entry.input)?,
        output: place(&entry.output)?,
        parameters: entry.parameters.iter().map(parameter).collect::<Option<_>>()?,
        ..entry.clone()
    })
}

/// An effect whose ranges are numbers in their units: those that are parts of what was recorded are multiplied by it.
pub fn scaled(effect: &MotionEffect, data: &Data) -> MotionEffect {
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut effect = effect.clone();
    for ((name, text), parameter) in effect.text.parameters.iter_mut().zip(&mut effect.parameters) {
        debug_assert_eq!(*name, parameter.name);
        let of = match text.of.take() {
            None => continue,
            Some(Part::Position) => largest(data.position),
            Some(Part::Speed) => data.scale.speed,
            Some(Part::Drive) => data.scale.drive,
            Some(Part::Step) => data.step_s,
            Some(Part::Duration) => data.duration_s,
        };
        for end in [&mut text.from, &mut text.to].into_iter().flatten() {
            *end *= of;
        }
        if let Some(range) = &mut parameter.range {
            (range.from, range.to) = (range.from * of, range.to * of);
        }
    }
    // The sentences hold ranges of their own.
    for added in &mut effect.adds {
        for (own, k) in added.sentence.parameters.iter_mut().zip(&added.parameters) {
            own.range = effect.parameters[*k].range;
        }
    }
    effect
}

#[cfg(test)]
mod tests {
    use super::*;
    use fitter::plant::PlantFile;

    #[test]
    fn every_effect_finds_its_place_in_a_driven_pendulum() {
        let text = "[plant]\nkind = \"equations\"\ninputs = { u = \"m/s^2\" }\n\
                    states = { phi = { unit = \"rad\", start = \"fit\" }, w = { unit = \"rad/s\", start = 0.0 } }\n\
                    output = { y = \"phi\" }\n[plant.equations]\nphi = \"w\"\nw = \"-a * sin(phi) + b * u * cos(phi)\"\n\
                    [plant.parameters]\na = { unit = \"1/s^2\", from = 1, to = 100 }\nb = { unit = \"rad/m\", value = 3 }\n";
        let file = PlantFile::parse("plant.toml", text).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let effects = effects(&plant);
        assert_eq!(effects.len(), entries().len());
        let friction = &effects[0];
        assert_eq!(friction.formula(&plant), "w' += -force_per_inertia * sign(w)");
        assert_eq!(friction.parameters[0].unit, Unit::parse("rad/s^2").unwrap());
        let without = text.replace("inputs = { u = \"m/s^2\" }\n", "").replace(" + b * u * cos(phi)", "");
        let without = without.replace("b = { unit = \"rad/m\", value = 3 }\n", "");
        let file = PlantFile::parse("plant.toml", &without).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let ids: Vec<String> = super::effects(&plant).iter().map(|e| e.text.id.clone()).collect();
        assert!(ids.contains(&"sensor_offset".into()) && !ids.contains(&"drive_lag".into()), "{ids:?}");
    }
}
