//! A second-order plant as one in equations: x′ = v, v′ = −damping·v − stiffness·x + gain·u, y = x.

use std::collections::BTreeMap;

use physics::Unit;

use super::equations::{EffectText, Equations, Fit, Named, PlantParameter, State, StateStart};
use super::{Kind, PlantFile};

/// Half the range of a parameter, over its nominal size.
const REACH: f64 = 10.0;

/// A key, what was found there and what was expected.
type Refused = (String, String, &'static str);

impl PlantFile {
    /// A second-order plant of one drive in equations, without its effects: damping, stiffness and gain begin at
    /// `numbers`, in a range of ten times their size around them.
    ///
    /// # Errors
    /// A unit that expressions cannot compute with, or feedback.
    pub fn as_equations(&self, numbers: [f64; 3]) -> Result<PlantFile, Refused> {
        let (position, drive) = self.units()?;
        if let Some(command) = &self.plant.feedback {
            let expected = "no such key: effects of your own are sought in free run";
            return Err(("plant.feedback".into(), format!("\"{command}\""), expected));
        }
        let [damping, stiffness, gain] = numbers;
        let rate = stiffness.abs().sqrt().max(damping.abs());
        let per_s = |power: f64| Unit::named("s").power(-power).unwrap_or_else(Unit::one);
        let of_drive = drive.power(-1.0).unwrap_or_else(Unit::one);
        let parameter = |name: &str, unit: Unit, value: f64, size: f64| {
            let (from, to) = (Some(value - REACH * size), Some(value + REACH * size));
            let (unit, value) = (unit.to_string(), Some(value));
            let parameter = PlantParameter { unit, value, from, to, of: None, starts: None };
            (name.to_string(), parameter)
        };
        let state = |unit: Unit| State { unit: unit.to_string(), start: StateStart::Fit(Fit::Fit) };
        let text = |name: &str, text: &str| (name.to_string(), text.to_string());
        let equations = Equations {
            inputs: Named(vec![("u".into(), drive.to_string())]),
            states: Named(vec![
                ("x".into(), state(position.clone())),
                ("v".into(), state(position.times(&per_s(1.0)))),
            ]),
            output: Named(vec![text("y", "x")]),
            sampling: self.plant.hold,
            equations: Named(vec![text("x", "v"), text("v", "-damping * v - stiffness * x + gain * u")]),
            parameters: Named(vec![
                parameter("damping", per_s(1.0), damping, rate),
                parameter("stiffness", per_s(2.0), stiffness, rate * rate),
                parameter("gain", position.times(&per_s(2.0)).times(&of_drive), gain, gain.abs()),
            ]),
            effects: Vec::new(),
        };
        let plant = super::Plant { kind: Kind::Equations, ..self.plant.clone() };
        Ok(PlantFile { plant, state_space: None, effects: Vec::new(), equations: Some(Box::new(equations)) })
    }

    /// An effect that is declared for a second-order plant as one of its equations: `acceleration` adds to v′, `drive` to u,
    /// `reading` to y; in the units of its parameters, `p` stands for the position's unit and `u` for the drive's.
    ///
    /// # Errors
    /// As [`PlantFile::as_equations`].
    pub fn effect_in_equations(&self, text: &EffectText) -> Result<EffectText, Refused> {
        let (position, drive) = self.units()?;
        let mut text = text.clone();
        let put = |added: &mut String, to: &mut BTreeMap<String, String>, name: &str| {
            if !added.is_empty() {
                to.insert(name.into(), std::mem::take(added));
            }
        };
        put(&mut text.acceleration, &mut text.equation, "v");
        put(&mut text.drive, &mut text.input, "u");
        put(&mut text.reading, &mut text.output, "y");
        for parameter in text.parameters.values_mut() {
            // What is no unit is refused where the effect is read.
            if let Ok(unit) = Unit::parse(&parameter.unit) {
                parameter.unit = unit.with("p", &position).with("u", &drive).to_string();
            }
        }
        Ok(text)
    }

    /// The units of position and drive.
    fn units(&self) -> Result<(Unit, Unit), Refused> {
        let read = |key: &str, text: &str| {
            let expected = "a unit such as rad, mm or V";
            Unit::parse(text).map_err(|_| (format!("plant.{key}"), format!("\"{text}\""), expected))
        };
        Ok((read("position_unit", &self.plant.position_unit)?, read("drive_unit", &self.plant.drive_unit)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_order_plant_is_a_sentence_of_equations() {
        let text = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n";
        let file = PlantFile::parse("plant.toml", text).unwrap();
        let plant = file.as_equations([-1.0, 400.0, 3.0]).unwrap();
        let again = PlantFile::parse("again.toml", &plant.to_toml()).unwrap();
        assert_eq!(again.equations, plant.equations, "{}", plant.to_toml());
        assert_eq!((again.plant.position_unit.as_str(), again.plant.drive_unit.as_str()), ("arcsec", "A"));
        let parameters = &plant.equations.unwrap().parameters;
        assert_eq!(parameters.get("damping").unwrap().from, Some(-201.0));
        assert_eq!(parameters.get("stiffness").unwrap().to, Some(4400.0));
        let text = text.to_string() + "feedback = \"command\"\n";
        let (key, ..) = PlantFile::parse("plant.toml", &text).unwrap().as_equations([1.0; 3]).unwrap_err();
        assert_eq!(key, "plant.feedback");
    }
}
