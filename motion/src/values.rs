//! An effect's parameters with their values, and what can be wrong with them.

use std::collections::BTreeMap;
use std::ops::Index;

fitter::errors! {
    /// Why an effect cannot be injected.
    #[derive(Debug, Clone, PartialEq)]
    pub enum EffectError {
        Text { text: String } =>
            says("`{text}` is no effect")
            expected("`id:parameter=value,…`, for example `mount_step:step_arcsec=3,time_s=400`");
        Number { id: String, parameter: String, value: String } =>
            says("effect `{id}`: `{value}` is no number for `{parameter}`");
        Id { id: String, expected: String } =>
            says("there is no effect `{id}`") expected("one of {expected}");
        Parameter { id: String, parameter: String, expected: String } =>
            says("effect `{id}` has no parameter `{parameter}`") expected("{expected}");
        Missing { id: String, parameter: &'static str, unit: &'static str } =>
            says("effect `{id}` needs `{parameter}` in {unit}");
        Range { id: String, parameter: &'static str, value: f64, least: f64, most: f64, unit: &'static str } =>
            says("effect `{id}`: `{parameter}` is {value}") expected("{least} to {most} {unit}");
        Settled { id: String } =>
            says("effect `{id}` shows only where the mirror is read while it moves, and this schedule lets \
                it settle")
            mend("use the schedule `scan`");
        Refused { id: String, reason: String } => says("effect `{id}`: {reason}");
    }
}

/// The values of an effect's parameters, all present and in their ranges.
#[derive(Debug, Clone, PartialEq)]
pub struct Values(BTreeMap<&'static str, f64>);

/// What is known of a parameter, wherever its effect acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is where it is not given; none where it must be given.
    pub default: Option<f64>,
    /// The least and the largest value that make sense.
    pub range: (f64, f64),
}

impl Known {
    /// One that has to be given.
    pub const fn needed(name: &'static str, unit: &'static str, range: (f64, f64)) -> Known {
        Known { name, unit, default: None, range }
    }

    /// One that is usually `default`.
    pub const fn usual(name: &'static str, unit: &'static str, default: f64, range: (f64, f64)) -> Known {
        Known { name, unit, default: Some(default), range }
    }
}

impl Values {
    /// Checks the given values of the effect `id` against what is known of its parameters, and fills in the
    /// defaults.
    ///
    /// # Errors
    /// [`EffectError`].
    pub fn check(id: &str, known: &[Known], given: &BTreeMap<String, f64>) -> Result<Values, EffectError> {
        let id = || id.to_owned();
        for name in given.keys() {
            if !known.iter().any(|p| p.name == name) {
                let expected = known.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
                return Err(EffectError::Parameter { id: id(), parameter: name.clone(), expected });
            }
        }
        let mut values = BTreeMap::new();
        for &Known { name, unit, default, range: (least, most) } in known {
            let value = given.get(name).copied().or(default);
            let value = value.ok_or_else(|| EffectError::Missing { id: id(), parameter: name, unit })?;
            if !(least..=most).contains(&value) {
                return Err(EffectError::Range { id: id(), parameter: name, value, least, most, unit });
            }
            values.insert(name, value);
        }
        Ok(Values(values))
    }
}

impl Index<&str> for Values {
    type Output = f64;

    /// The value of a parameter that the effect's own specification names.
    fn index(&self, name: &str) -> &f64 {
        &self.0[name]
    }
}
