//! The nominal plant, `plant.toml`, and the same file augmented by what a diagnosis found: one format that a
//! simulation reads and an identification writes. The meaning of every number stands here and nowhere else.
//!
//! With x the position, v its velocity, u the recorded drive and w the drive that reaches the mechanism,
//! `kind = "second-order"` is x″ = −damping·v − stiffness·x + gain·w, inertia-normalised; `gain` is a list
//! where there are several drives (their forces add). `kind = "linear"` is a discrete-time state space
//! (table `[state_space]`): z′ = A z + B w, x = C z + D w from one sample to the next; `kind = "equations"` is a module of
//! its own ([`equations`]). What is recorded is y = x. `[[effects]]` add to that:
//!
//! | `id` | what it adds | parameters |
//! |---|---|---|
//! | `coulomb_friction` | x″ −= F·sign v; it holds the mechanism where \|force\| ≤ F | `force_per_inertia` F |
//! | `stribeck_friction` | x″ −= (F + E·exp(−\|v/v_s\|ᵟ))·sign v; holds up to F + E | F, `extra_static` E, `stribeck_velocity` v_s; `exponent` δ (2) |
//! | `local_friction` | x″ −= F·exp(−((x − c)/w)²)·sign v | `force_per_inertia` F, `centre` c, `width` w |
//! | `backlash` | x″ += F·sign v while x crosses a play of width b: what lies beyond it stands still | `friction_beyond` F, `play` b |
//! | `cubic_stiffness` | x″ −= c·x³ | `coefficient` |
//! | `quadratic_stiffness` | x″ −= c·x² | `coefficient` |
//! | `quadratic_damping` | x″ −= c·v·\|v\| | `coefficient` |
//! | `nonlinear_damping` | x″ −= c·x²·v | `coefficient` |
//! | `bouc_wen_hysteresis` | x″ −= k·z, z′ = v·(1 − (β·sign(v z) + 1 − β)·\|z/Y\|ⁿ) | `stiffness` k, `yield` Y; `beta` (0.5), `exponent` n (1) |
//! | `rayleigh_hysteresis` | w = u + c·R(u): R = u·\|u\| on the virgin curve, R = R_r + ½(u−u_r)·\|u−u_r\| from the reversal (u_r, R_r), return-point memory | `coefficient` c: a number, or a list with one per drive |
//! | `rayleigh_hysteresis` of a `linear` plant | z′ += E·w, x += F·w with w_l = Σ_k g_k·p_k(ζ_l), ζ = C·z + D·u; p_k is the play of half-width r_k, p ← min(max(p, ζ − r), ζ + r), from 0 | by rows: `into_state` E, `into_position` F, `from_state` C, `from_drive` D; `thresholds` r, `weights` g |
//! | `transport_delay` | w(t) = u(t − T) | `delay_s` |
//! | `drive_lag` | τ w′ = u − w | `time_constant_s` |
//! | `sensor_lag` | τ y′ = x − y | `time_constant_s` |
//! | `flexible_mode` | x″ −= μ·h, q″ = h, h = Ω²(x−q) + 2ζΩ(v−q′), Ω = 2πf: an attached inertia μ | `frequency_hz`, `mass_ratio` μ; `damping_ratio` ζ (0.01) |
//! | `drive_saturation` | w = u within ±limit | `limit` |
//! | `drive_offset` | w = u + o; under `feedback` w = u − o: there the drive is predicted, and o adds to it | `offset` o |
//! | `sensor_offset` | y = x + o | `offset` o |
//! | `cogging` | x″ −= A·sin(2πx/p + φ) | `amplitude_per_inertia` A, `period` p; `phase_rad` φ (0) |
//! | `torque_constant_droop` | gain·(1 − δ·x²) | `droop` δ |
//!
//! On the way from u to w the order is delay, offset, saturation, lag, Rayleigh; on the way from x to y lag,
//! offset. Units are those of the file and seconds.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub mod equations;
mod second_order;

pub use equations::Equations;

use crate::input;
use crate::keys::{self, KeyError, quoted};
use crate::text_safety;

/// A whole `plant.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantFile {
    /// The nominal mechanism.
    pub plant: Plant,
    /// The matrices of an identified `linear` plant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state_space: Option<StateSpace>,
    /// What was found beyond the nominal mechanism.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<PlantEffect>,
    /// A plant that is stated in equations, with its effects.
    #[serde(skip)]
    pub equations: Option<Box<Equations>>,
}

/// The table `[plant]`. Numbers are absent before the plant is identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// The structure.
    pub kind: Kind,
    /// Number of states of a `linear` plant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Order>,
    /// Unit of `position`.
    pub position_unit: String,
    /// Unit of `drive`.
    pub drive_unit: String,
    /// The column that the controller followed, where the recording was taken under feedback.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<String>,
    /// Damping per inertia, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Stiffness per inertia, 1/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Gain per inertia, position unit per s² and drive unit; one number or one per drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<Numbers>,
    /// How the drive runs between its samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<Hold>,
}

/// Structure of the nominal plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One inertia on a spring and a damper.
    SecondOrder,
    /// Multivariable linear state space.
    Linear,
    /// Any equations, which the file states.
    Equations,
}

/// Order of a `linear` plant: a number of states, or `"auto"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Order {
    /// As many states.
    States(usize),
    /// Chosen from the data.
    Auto(Auto),
}

/// The word `"auto"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Auto {
    /// `"auto"`
    Auto,
}

/// How the drive runs between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// Held at the last sample (a DAC).
    ZeroOrder,
    /// Straight from one sample to the next.
    FirstOrder,
    /// Smooth: no content above half the sampling rate.
    BandLimited,
}

/// One number, or one per drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Numbers {
    /// The same for every drive.
    One(f64),
    /// One per drive, in their order.
    Each(Vec<f64>),
}

impl Numbers {
    /// The number that holds for drive `index`, where there is one.
    pub fn get(&self, index: usize) -> Option<f64> {
        match self {
            Numbers::One(value) => Some(*value),
            Numbers::Each(values) => values.get(index).copied(),
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Numbers::One(value) => value.is_finite(),
            Numbers::Each(values) => !values.is_empty() && values.iter().all(|value| value.is_finite()),
        }
    }
}

/// One of the tables `[[effects]]`: an id and its parameters by name, see the table of the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantEffect {
    /// Its id.
    pub id: String,
    /// Its parameters by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Numbers>,
}

impl PlantEffect {
    /// An effect of single numbers.
    pub fn new(id: &str, parameters: &[(&str, f64)]) -> PlantEffect {
        let one = |&(name, value): &(&str, f64)| (name.to_string(), Numbers::One(value));
        PlantEffect { id: id.to_string(), parameters: parameters.iter().map(one).collect() }
    }

    /// The parameter `name`, where it is given as a single number.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.parameters.get(name) {
            Some(Numbers::One(value)) => Some(*value),
            _ => None,
        }
    }
}

/// The table `[state_space]`: z′ = A z + B w, x = C z + D w from one sample to the next; n states, m drives,
/// p positions. Matrices are lists of rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateSpace {
    /// Time from one sample to the next, s. The matrices hold at this sampling rate only.
    pub sample_time_s: f64,
    /// A, n × n.
    pub a: Vec<Vec<f64>>,
    /// B, n × m.
    pub b: Vec<Vec<f64>>,
    /// C, p × n.
    pub c: Vec<Vec<f64>>,
    /// D, p × m.
    pub d: Vec<Vec<f64>>,
}

const TABLES: &[&str] = &["plant", "state_space", "effects"];
const PLANT_KEYS: &[&str] =
    &["kind", "order", "position_unit", "drive_unit", "feedback", "damping", "stiffness", "gain", "hold"];
const NEEDED: [(&str, &str, &str); 3] = [
    ("kind", "plant.kind", "\"second-order\", \"linear\" or \"equations\""),
    ("position_unit", "plant.position_unit", "the unit of `position`, for example \"arcsec\""),
    ("drive_unit", "plant.drive_unit", "the unit of `drive`, for example \"A\""),
];

impl PlantFile {
    /// Reads `plant.toml`.
    ///
    /// # Errors
    /// One of [`KeyError`]; an unknown key is refused and the nearest known one suggested.
    pub fn read(path: &Path) -> Result<PlantFile, KeyError> {
        keys::read(path, "plant.toml", TABLES, PlantFile::parse)
    }

    /// Parses the text of a plant file; `file` is the name that stands in messages.
    ///
    /// # Errors
    /// As [`PlantFile::read`].
    pub fn parse(file: &str, text: &str) -> Result<PlantFile, KeyError> {
        input::expect(file, text.as_bytes(), input::Kind::Plant)?;
        let syntax = |error: toml::de::Error| KeyError::syntax(file, text, &error);
        let table: toml::Table = text.parse().map_err(syntax)?;
        let kind = table.get("plant").and_then(|plant| plant.get("kind")).and_then(toml::Value::as_str);
        if kind == Some("equations") {
            return PlantFile::in_equations(file, Equations::parse(text).map_err(syntax)?);
        }
        check_keys(file, &table)?;
        let plant: PlantFile = toml::from_str(text).map_err(syntax)?;
        plant.check(file)?;
        Ok(plant)
    }

    /// A plant in equations, in the units of its output and its first input.
    fn in_equations(file: &str, equations: Equations) -> Result<PlantFile, KeyError> {
        let wrong = |(key, found, expected)| KeyError::Value { file: file.to_string(), key, found, expected };
        equations.check().map_err(wrong)?;
        let drive_unit = equations.inputs.0.first().map_or_else(String::new, |(_, unit)| unit.clone());
        let position_unit = equations.output_unit().map_err(wrong)?;
        let plant = Plant {
            kind: Kind::Equations,
            order: None,
            position_unit,
            drive_unit,
            feedback: None,
            damping: None,
            stiffness: None,
            gain: None,
            hold: equations.sampling,
        };
        let equations = Some(Box::new(equations));
        Ok(PlantFile { plant, state_space: None, effects: Vec::new(), equations })
    }

    /// Refuses effects that are not among the `known` ones; `file` is the name that stands in the message.
    ///
    /// # Errors
    /// [`KeyError::Unknown`], with the nearest known one.
    pub fn check_effects(&self, file: &str, known: &[&str]) -> Result<(), KeyError> {
        match self.effects.iter().find(|effect| !known.contains(&effect.id.as_str())) {
            None => Ok(()),
            Some(PlantEffect { id, .. }) => {
                let expected = format!("one of {}", known.join(", "));
                Err(KeyError::unknown(file, id, known, format!("unknown effect `{id}`"), expected))
            }
        }
    }

    /// Refuses parameters that an effect does not have; `known` gives their names by its id.
    ///
    /// # Errors
    /// [`KeyError::Unknown`], with the nearest known one.
    pub fn check_parameters(
        &self,
        file: &str,
        known: impl Fn(&str) -> Vec<&'static str>,
    ) -> Result<(), KeyError> {
        for effect in &self.effects {
            let known = known(&effect.id);
            if let Some(name) = effect.parameters.keys().find(|name| !known.contains(&name.as_str())) {
                let found = format!("effect `{}` has no parameter `{name}`", effect.id);
                return Err(KeyError::unknown(file, name, &known, found, quoted(&known)));
            }
        }
        Ok(())
    }

    /// The file's text; [`PlantFile::parse`] gives the same plant back, to the last bit.
    pub fn to_toml(&self) -> String {
        if let Some(equations) = &self.equations {
            return equations.to_toml();
        }
        // Only maps with keys that are no strings and values after tables cannot be written; there are none.
        toml::to_string(self).unwrap_or_default()
    }

    fn check(&self, file: &str) -> Result<(), KeyError> {
        let wrong = |key: String, found: String, expected: &'static str| {
            Err(KeyError::Value { file: file.to_string(), key, found, expected })
        };
        let plant = &self.plant;
        for (key, unit) in [("position_unit", &plant.position_unit), ("drive_unit", &plant.drive_unit)] {
            if unit.trim().is_empty() {
                return wrong(format!("plant.{key}"), String::from("\"\""), "the name of a unit");
            }
            if let Err(reason) = text_safety::name(unit) {
                let found = format!("\"{}\", which {reason}", text_safety::cell(unit.as_bytes()));
                return wrong(format!("plant.{key}"), found, "the name of a unit");
            }
        }
        for (key, value) in [("damping", plant.damping), ("stiffness", plant.stiffness)] {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return wrong(format!("plant.{key}"), value.to_string(), "a finite number");
            }
        }
        if let Some(gain) = plant.gain.as_ref().filter(|gain| !gain.is_finite()) {
            return wrong(
                String::from("plant.gain"),
                format!("{gain:?}"),
                "finite, one number or one per drive",
            );
        }
        if plant.order == Some(Order::States(0)) {
            return wrong(String::from("plant.order"), String::from("0"), "one state or more, or \"auto\"");
        }
        for effect in &self.effects {
            if let Some((name, value)) = effect.parameters.iter().find(|(_, value)| !value.is_finite()) {
                return wrong(format!("{}.{name}", effect.id), format!("{value:?}"), "finite numbers");
            }
        }
        match &self.state_space {
            Some(space) => space.check(file),
            None => Ok(()),
        }
    }
}

impl StateSpace {
    /// Numbers of states, drives and positions, (n, m, p).
    pub fn sizes(&self) -> (usize, usize, usize) {
        let drives = self.d.first().map_or(0, Vec::len);
        (self.a.len(), drives, self.c.len())
    }

    fn check(&self, file: &str) -> Result<(), KeyError> {
        let (n, m, p) = self.sizes();
        let wrong = |key: &str, found: String, expected: &'static str| {
            Err(KeyError::Value {
                file: file.to_string(),
                key: format!("state_space.{key}"),
                found,
                expected,
            })
        };
        if !(self.sample_time_s.is_finite() && self.sample_time_s > 0.0) {
            return wrong("sample_time_s", self.sample_time_s.to_string(), "a time above zero, in s");
        }
        let matrices =
            [("a", &self.a, n, n), ("b", &self.b, n, m), ("c", &self.c, p, n), ("d", &self.d, p, m)];
        for (key, matrix, rows, columns) in matrices {
            if matrix.len() != rows || matrix.iter().any(|row| row.len() != columns) {
                let found = format!("no {rows} × {columns} matrix");
                return wrong(key, found, "rows that fit: a n × n, b n × m, c p × n, d p × m");
            }
            if matrix.iter().flatten().any(|value| !value.is_finite()) {
                return wrong(key, String::from("not finite throughout"), "finite numbers");
            }
        }
        if m == 0 || p == 0 {
            return wrong("d", String::from("empty"), "a row per position, a column per drive");
        }
        Ok(())
    }
}

fn check_keys(file: &str, table: &toml::Table) -> Result<(), KeyError> {
    let unknown = |key: &str, name: &str, known: &[&str]| {
        let expected = format!("one of {}", quoted(known));
        KeyError::unknown(file, name, known, format!("unknown key `{key}`"), expected)
    };
    if let Some(key) = table.keys().find(|key| !TABLES.contains(&key.as_str())) {
        return Err(unknown(key, key, TABLES));
    }
    let missing = |key, expected| KeyError::MissingKey { file: file.to_string(), key, expected };
    let Some(toml::Value::Table(plant)) = table.get("plant") else {
        return Err(missing("[plant]", "a table with `kind`, `position_unit` and `drive_unit`"));
    };
    if let Some(key) = plant.keys().find(|key| !PLANT_KEYS.contains(&key.as_str())) {
        return Err(unknown(&format!("plant.{key}"), key, PLANT_KEYS));
    }
    match NEEDED.iter().find(|(key, ..)| !plant.contains_key(*key)) {
        Some((_, key, expected)) => Err(missing(key, expected)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AUGMENTED: &str = r#"
[plant]
kind = "second-order"
position_unit = "arcsec"
drive_unit = "A"
damping = 37.7
stiffness = 41290
gain = 376568596.51786536
hold = "band-limited"

[[effects]]
id = "coulomb_friction"
force_per_inertia = 668999.7161398806

[[effects]]
id = "rayleigh_hysteresis"
coefficient = [0.1, 0.2, 3]
"#;

    #[test]
    fn an_augmented_plant_reads_back_bit_for_bit() {
        let plant = PlantFile::parse("plant.toml", AUGMENTED).unwrap();
        assert_eq!(plant.plant.stiffness, Some(41290.0));
        assert_eq!(plant.plant.hold, Some(Hold::BandLimited));
        assert_eq!(plant.effects[0].number("force_per_inertia"), Some(668999.7161398806));
        assert_eq!(plant.effects[1].parameters["coefficient"].get(2), Some(3.0));
        assert_eq!(PlantFile::parse("again", &plant.to_toml()).unwrap(), plant);
    }

    #[test]
    fn a_linear_plant_carries_its_matrices() {
        let text = "[plant]\nkind = \"linear\"\norder = \"auto\"\nposition_unit = \"um\"\ndrive_unit = \"V\"\n\
                    [state_space]\nsample_time_s = 1e-3\na = [[0.5]]\nb = [[1, 2]]\nc = [[1.0]]\nd = [[0, 0]]\n";
        let plant = PlantFile::parse("plant.toml", text).unwrap();
        assert_eq!(plant.plant.order, Some(Order::Auto(Auto::Auto)));
        assert_eq!(plant.state_space.as_ref().unwrap().sizes(), (1, 2, 1));
        assert_eq!(PlantFile::parse("again", &plant.to_toml()).unwrap(), plant);
        let error = PlantFile::parse("p.toml", &text.replace("[[1, 2]]", "[[1]]")).unwrap_err().to_string();
        assert!(error.contains("state_space.b") && error.contains("1 × 2"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cases = [
            (AUGMENTED.replace("drive_unit = \"A\"\n", ""), "`plant.drive_unit` is missing"),
            (AUGMENTED.replace("drive_unit = \"A\"", "drive_unit = \"\""), "`plant.drive_unit` is \"\""),
            (AUGMENTED.replace("damping", "dampin"), "did you mean `damping`?"),
            (AUGMENTED.replace("37.7", "nan"), "`plant.damping` is NaN"),
            (AUGMENTED.replace("37.7", "\"x\""), "line 6"),
            (AUGMENTED.replace("[plant]", "[planet]"), "did you mean `plant`?"),
            (AUGMENTED.replace("[0.1, 0.2, 3]", "[]"), "`rayleigh_hysteresis.coefficient`"),
            (AUGMENTED.replace("band-limited", "bandlimited"), "line 9"),
        ];
        for (text, expected) in cases {
            let error = PlantFile::parse("plant.toml", &text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }
}
