//! The catalogue of effects in motion, wherever they fit into a plant in equations.

use std::sync::Arc;

use fitter::plant::equations::{EffectText, Part, PlantParameter, declared};
use motion::equations::{MotionEffect, Plant};
use numerics::{mean, range};
use physics::Unit;

use super::super::data::Data;
use super::super::recording::DynamicRecording;
use crate::thresholds::dynamic::equations::{MOMENT, PLACES};

/// The catalogue as it is written.
const TEXT: &str = include_str!("catalogue.toml");
/// Forms without a name as they are written.
const FORMS: &str = include_str!("forms.toml");

/// Which names of a plant the names of the catalogue stand for.
#[derive(Clone, Default)]
struct Binding<'a> {
    /// A state and the state that is its rate.
    momentum: Option<[&'a (String, Unit); 2]>,
    /// A state that is in no such pair: the level of a tank, a charge, a temperature.
    level: Option<&'a (String, Unit)>,
    /// Another one, whose rate depends on the level.
    next: Option<&'a (String, Unit)>,
    input: Option<&'a (String, Unit)>,
    output: Option<(&'a String, &'a Unit)>,
    /// A further column of the recording, and its mean as it is written.
    column: Option<(&'a (String, Unit), &'a str)>,
}

/// The entries of the catalogue.
pub fn entries() -> Vec<EffectText> {
    // The text is a part of the program, and a test reads it.
    declared("catalogue.toml", TEXT).unwrap_or_default()
}

/// The forms without a name beside samples so far apart, one for every part of the stroke where they say so.
fn form_entries(step_s: f64) -> Vec<EffectText> {
    let in_places = |form: &str| -> Vec<String> {
        let places = if form.contains("{k}") { PLACES } else { 1 };
        let end = |k: usize| (2.0 * k as f64 / PLACES as f64 - 1.0).to_string();
        let with = |text: String, name: &str, value: String| text.replace(name, &value);
        let one = |k: usize| {
            let text = with(format!("[[effect]]{form}"), "{k}", (k + 1).to_string());
            with(with(text, "{from}", end(k)), "{to}", end(k + 1))
        };
        (0..places).map(one).collect()
    };
    let forms = FORMS.replace("{moment}", &(MOMENT * step_s).to_string());
    let text: String = forms.split("[[effect]]").skip(1).flat_map(in_places).collect();
    // The text is a part of the program, and a test reads it.
    declared("forms.toml", &text).unwrap_or_default()
}

/// Every effect of the catalogue in every place of a plant into which it fits; the first so many inputs are drives, the
/// others further columns. Where there are several places the id ends in the name of the place.
pub fn effects(plant: &Plant, drives: usize) -> Vec<Arc<MotionEffect>> {
    placed("catalogue.toml", &entries(), plant, drives, &[])
}

/// The forms without a name, likewise; of further columns around their mean, so that what else goes with the state keeps the
/// value that it has there.
pub fn forms(plant: &Plant, recording: &DynamicRecording) -> Vec<Arc<MotionEffect>> {
    let drives = recording.drives.len();
    let middles: Vec<String> =
        plant.inputs.iter().skip(drives).map(|(column, _)| middle(recording, column)).collect();
    placed("forms.toml", &form_entries(recording.step_s), plant, drives, &middles)
}

/// The mean of a column to a thousandth of its range, as it is written.
fn middle(recording: &DynamicRecording, column: &str) -> String {
    let values = recording.further.iter().find(|(name, _)| name == column).map(|(_, values)| values);
    let Some(values) = values else { return "0".into() };
    let (low, high) = range(values);
    let decimals = (3.0 - (high - low).max(f64::MIN_POSITIVE).log10()).ceil().clamp(0.0, 12.0) as usize;
    format!("{:.decimals$}", mean(values))
}

/// Entries wherever they fit into a plant. `middles` are the means of the further columns, as they are written.
fn placed<'p>(
    file: &str,
    entries: &[EffectText],
    plant: &'p Plant,
    drives: usize,
    middles: &'p [String],
) -> Vec<Arc<MotionEffect>> {
    let (inputs, columns) = plant.inputs.split_at(drives.min(plant.inputs.len()));
    let momenta: Vec<[&(String, Unit); 2]> = plant
        .states
        .iter()
        .zip(&plant.rates)
        .filter_map(|(x, (rate, _))| Some([x, plant.states.iter().find(|(name, _)| *name == rate.text)?]))
        .collect();
    let in_place = |entry: &EffectText| {
        let mut bindings: Vec<Binding> = of_states(entry, plant, &momenta);
        if entry.input.contains_key("u") || reads(entry, "u") {
            let one = |of: Binding<'p>| inputs.iter().map(move |u| Binding { input: Some(u), ..of.clone() });
            bindings = bindings.into_iter().flat_map(one).collect();
        }
        if !entry.output.is_empty() {
            let output = Some((&plant.output.0, plant.output_unit()));
            bindings.iter_mut().for_each(|binding| binding.output = output);
        }
        let several = bindings.len() > 1;
        if reads(entry, "z") {
            let columns = |of: Binding<'p>| {
                let one =
                    move |(z, middle): (_, &'p String)| Binding { column: Some((z, middle)), ..of.clone() };
                columns.iter().zip(middles).map(one)
            };
            bindings = bindings.into_iter().flat_map(columns).collect();
        }
        let bound = |binding: &Binding| {
            let mut text = bound(entry, binding)?;
            if several {
                let state = binding.momentum.map(|[_, v]| v).or(binding.level);
                let (place, _) = state.or(binding.input)?;
                text.id = format!("{}_{place}", text.id);
            }
            if let Some(((column, _), _)) = binding.column {
                text = of_column(text, column);
            }
            plant.effect(file, &text).ok().map(Arc::new)
        };
        bindings.iter().filter_map(bound).collect::<Vec<_>>()
    };
    entries.iter().flat_map(in_place).collect()
}

/// The states that an effect may act on: one and its rate, a level, or a level and the next one.
fn of_states<'p>(
    entry: &EffectText,
    plant: &'p Plant,
    momenta: &[[&'p (String, Unit); 2]],
) -> Vec<Binding<'p>> {
    let none = Binding::default();
    if entry.equation.is_empty() {
        return vec![none];
    }
    if !entry.equation.contains_key("level") {
        return momenta.iter().map(|pair| Binding { momentum: Some(*pair), ..none.clone() }).collect();
    }
    let moves = |name: &String| momenta.iter().flatten().any(|(own, _)| own == name);
    let levels = || plant.states.iter().zip(&plant.rates).filter(|((name, _), _)| !moves(name));
    // A threshold is sought in parts of the recorded position, of which no other quantity is.
    let recorded = |unit: &Unit| unit == plant.output_unit();
    let of_position = entry.parameters.values().any(|p| p.of == Some(Part::Position));
    let one = |(level, _): (&'p (String, Unit), _)| {
        (!of_position || recorded(&level.1)).then_some(Binding { level: Some(level), ..none.clone() })
    };
    let alone: Vec<Binding> = levels().filter_map(one).collect();
    if !entry.equation.contains_key("next") {
        return alone;
    }
    let onward = |of: &Binding<'p>| {
        let level = of.level;
        let fed = move |(other, (rate, _)): (&'p (String, Unit), &'p (physics::Sentence, Vec<usize>))| {
            let own = level.is_some_and(|level| level != other && rate.columns.contains(&level.0));
            own.then_some(Binding { level, next: Some(other), ..Binding::default() })
        };
        levels().filter_map(fed).collect::<Vec<_>>()
    };
    alone.iter().flat_map(onward).collect()
}

/// A form of a column: its id ends in the column's name.
fn of_column(mut text: EffectText, column: &str) -> EffectText {
    text.id = format!("{}_{column}", text.id);
    let words = [&mut text.title, &mut text.experiment].into_iter().chain(&mut text.readings);
    words.for_each(|words| *words = words.replace("{z}", column));
    text
}

/// Whether an effect reads a name.
fn reads(entry: &EffectText, name: &str) -> bool {
    expressions(entry).any(|expression| expression.names().contains(&name))
}

/// What an effect adds anywhere.
pub fn expressions(entry: &EffectText) -> impl Iterator<Item = physics::Expression> {
    let texts = entry.equation.values().chain(entry.input.values()).chain(entry.output.values());
    texts.chain(entry.states.values()).filter_map(|text| physics::parse(text).ok())
}

/// An entry in the names and units of a plant.
fn bound<'p>(entry: &EffectText, binding: &Binding<'p>) -> Option<EffectText> {
    let name = |name: &str| match name {
        "x" => binding.momentum.map(|[x, _]| x.0.clone()),
        "v" => binding.momentum.map(|[_, v]| v.0.clone()),
        "level" => binding.level.map(|(level, _)| level.clone()),
        "next" => binding.next.map(|(next, _)| next.clone()),
        "u" => binding.input.map(|(u, _)| u.clone()),
        "y" => binding.output.map(|(y, _)| y.clone()),
        "z" => binding.column.map(|((z, _), _)| z.clone()),
        "middle" => binding.column.map(|((_, unit), middle)| match middle.starts_with('-') {
            true => format!("({middle} [{unit}])"),
            false => format!("{middle} [{unit}]"),
        }),
        _ => None,
    };
    let place = |map: &std::collections::BTreeMap<String, String>| {
        let one = |(own, text): (&String, &String)| {
            let expression = physics::parse(text).ok()?.renamed(&name);
            Some((name(own)?, expression.to_string()))
        };
        map.iter().map(one).collect::<Option<_>>()
    };
    let renamed = |(own, text): (&String, &String)| {
        Some((own.clone(), physics::parse(text).ok()?.renamed(&name).to_string()))
    };
    let states = entry.states.iter().map(renamed).collect::<Option<_>>()?;
    let unit_of = |of: Option<&'p (String, Unit)>| of.map(|(_, unit)| unit);
    let state = binding.momentum.map(|[x, _]| &x.1).or(unit_of(binding.level));
    let position = state.or(binding.output.map(|(_, unit)| unit));
    let parameter = |(name, parameter): (&String, &PlantParameter)| {
        let mut unit = Unit::parse(&parameter.unit).ok()?;
        let column = binding.column.map(|(column, _)| column);
        let [input, column, next] = [binding.input, column, binding.next].map(unit_of);
        for (own, of_plant) in [("p", position), ("q", input), ("r", column), ("n", next)] {
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
        states,
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
        let effects = effects(&plant, 1);
        assert_eq!(effects.len(), entries().len());
        let friction = &effects[0];
        assert_eq!(friction.formula(&plant), "w' += -force_per_inertia * sign(w)");
        assert_eq!(friction.parameters[0].unit, Unit::parse("rad/s^2").unwrap());
        let without = text.replace("inputs = { u = \"m/s^2\" }\n", "").replace(" + b * u * cos(phi)", "");
        let without = without.replace("b = { unit = \"rad/m\", value = 3 }\n", "");
        let file = PlantFile::parse("plant.toml", &without).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let ids: Vec<String> = super::effects(&plant, 0).iter().map(|e| e.text.id.clone()).collect();
        assert!(ids.contains(&"sensor_offset".into()) && !ids.contains(&"drive_lag".into()), "{ids:?}");
    }

    #[test]
    fn every_form_finds_its_place_in_a_mechanism_with_a_further_column() {
        let text = "[plant]\nkind = \"equations\"\ninputs = { w = \"A\", load_n = \"N\" }\n\
                    states = { q = { unit = \"mm\", start = 0.0 }, s = { unit = \"mm/s\", start = 0.0 } }\n\
                    output = { y = \"q\" }\n[plant.equations]\nq = \"s\"\ns = \"-k * q + g * w\"\n\
                    [plant.parameters]\nk = { unit = \"1/s^2\", value = 3 }\ng = { unit = \"mm/(s^2 A)\", value = 1 }\n";
        let file = PlantFile::parse("plant.toml", text).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let mut recording = DynamicRecording::made(1e-3, vec![0.0; 3], vec![0.0; 3]);
        recording.further.push(("load_n".into(), vec![20.0, 22.0, 27.001].into()));
        let (forms, mut all) = (forms(&plant, &recording), form_entries(1e-3));
        all.retain(|form| !form.equation.contains_key("level"));
        let ids: Vec<&str> = forms.iter().map(|form| form.text.id.as_str()).collect();
        assert!(all.len() > PLACES && forms.len() == all.len(), "{ids:?} of {}", all.len());
        assert!(ids.contains(&"form_near_8") && ids.contains(&"form_stiffness_with_load_n"), "{ids:?}");
        assert!(forms.iter().all(|form| !form.text.readings.is_empty() && !form.text.experiment.is_empty()));
        let gain = forms.iter().find(|form| form.text.id == "form_gain_with_load_n").unwrap();
        assert_eq!(gain.formula(&plant), "w += c * (load_n - 23.000 [N]) * w");
        assert_eq!(gain.parameters[0].unit, Unit::parse("1/N").unwrap());
    }

    #[test]
    fn levels_overflow_into_the_next() {
        let text = "[plant]\nkind = \"equations\"\ninputs = { w = \"V\" }\n\
                    states = { h = { unit = \"cm\", start = 1.0 }, l = { unit = \"cm\", start = 1.0 }, \
                    k = { unit = \"K\", start = 0.0 } }\n\
                    output = { y = \"l\" }\n[plant.equations]\nh = \"g * w - a * h\"\nl = \"a * h - b * l\"\n\
                    k = \"c * w - a * k\"\n\
                    [plant.parameters]\na = { unit = \"1/s\", value = 3 }\nb = { unit = \"1/s\", value = 3 }\n\
                    g = { unit = \"cm/(s V)\", value = 1 }\nc = { unit = \"K/(s V)\", value = 1 }\n";
        let file = PlantFile::parse("plant.toml", text).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let forms = forms(&plant, &DynamicRecording::made(0.5, vec![0.0; 3], vec![0.0; 3]));
        let of = |id: &str| forms.iter().find(|form| form.text.id == id).map(|form| form.formula(&plant));
        // Where it overflows is sought in parts of the recorded level: of a temperature there is none.
        assert!(of("form_overflow_h").is_some() && of("form_overflow_k").is_none());
        assert!(of("form_leak_k").is_some() && of("form_level_gain_l").is_some());
        let spills = "h' += -hinge(h, at) / 0.125 [s]; l' += share * hinge(h, at) / 0.125 [s]";
        assert_eq!(of("form_spill").as_deref(), Some(spills));
        assert!(!forms.iter().any(|form| form.text.id.starts_with("form_side_damping")));
    }
}
