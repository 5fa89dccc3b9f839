//! The results of a fleet, read back from its tables: what the page over all is made of. Of a unit it takes some kilobytes.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use codegen::refused;
use diagnosis::fleet::{Estimate, Forced, Test};
use fitter::text_safety;
use parquet::record::Row;

use super::answer::Unit;
use super::manifest::{Manifest, paths};
use super::parts::{self, number, numbers, text, texts};
use super::table::{NAMED, test};
use crate::terminal::Result;

/// One unit.
pub struct OfUnit {
    /// Which.
    pub unit: Unit,
    /// Its verdict; none where it failed.
    pub verdict: Option<String>,
    /// Ids of the effects that its diagnosis names.
    pub effects: Vec<String>,
    /// Unit of noise and root mean square.
    pub unit_of_measure: String,
    /// Noise of a reading, and root mean square of what is left, with standard errors.
    pub noise: Option<Estimate>,
    pub left: Option<Estimate>,
    /// Why it failed.
    pub error: Option<String>,
}

/// See the module.
pub struct Results {
    /// The units in their order.
    pub units: Vec<OfUnit>,
    /// What the recording of each says of every effect.
    pub forced: Vec<Forced>,
    /// Parameters of the effects that units name: by effect, parameter and unit of measure, with the number of the unit.
    pub named: BTreeMap<(String, String, String), Vec<(usize, Estimate)>>,
}

const OF_UNIT: [&str; 15] = [
    "unit",
    "file",
    "lot",
    "time",
    "rows",
    "verdict",
    "effects",
    "unit_of_measure",
    "rms_after",
    "noise",
    "error",
    "tests",
    "terms",
    "scores",
    "information",
];
const OF_PARAMETER: [&str; 6] = ["unit", "kind", "effect", "parameter", "unit_of_measure", "value"];

impl Results {
    /// Reads the results in a folder, which must be finished.
    pub fn of_folder(out: &Path) -> Result<Results> {
        let unfinished = |what: &str| {
            refused!("{what}")
                .at(&text_safety::path(out))
                .expected("the finished results of `arcsmith fleet`")
        };
        let manifest = Manifest::read(out)?.ok_or_else(|| unfinished("holds no manifest.json"))?;
        let there = manifest.with_parts_that_are_there(out)?;
        match there.parts.iter().all(Option::is_some) {
            true => Results::read(out, there.parts.len()),
            false => Err(unfinished("not all of its parts are there").mend("finish them with --resume")),
        }
    }

    /// Reads so many parts.
    pub fn read(out: &Path, parts: usize) -> Result<Results> {
        let mut results = Results { units: Vec::new(), forced: Vec::new(), named: BTreeMap::new() };
        let mut known: BTreeMap<Vec<String>, Arc<[Test]>> = BTreeMap::new();
        for part in 0..parts {
            let [units, parameters] = paths(out, part);
            let first = results.units.len();
            parts::read(&units, &OF_UNIT, &mut |row| results.push(row, &mut known))?;
            let names = results.units[first..].iter().zip(first..);
            let numbers: BTreeMap<String, usize> = names.map(|(of, k)| (of.unit.name.clone(), k)).collect();
            let columns = [&OF_PARAMETER[..], &["standard_error"]].concat();
            parts::read(&parameters, &columns, &mut |row| results.push_parameter(row, &numbers))?;
        }
        Ok(results)
    }

    fn push(&mut self, row: &Row, known: &mut BTreeMap<Vec<String>, Arc<[Test]>>) {
        let blank = |column| text(row, column).unwrap_or_default();
        // The standard error of a standard deviation.
        let part = number(row, "rows").map_or(1.0, |rows| (2.0 * rows).sqrt().recip());
        let deviation = |column| {
            let value: f64 = number(row, column)?;
            (value > 0.0).then_some(Estimate { value, error: part * value })
        };
        let written = texts(row, "tests");
        let tests =
            known.entry(written).or_insert_with_key(|all| all.iter().filter_map(|one| test(one)).collect());
        self.forced.push(Forced {
            tests: Arc::clone(tests),
            terms: texts(row, "terms"),
            scores: numbers(row, "scores"),
            information: numbers(row, "information"),
        });
        let unit = Unit {
            name: blank("unit"),
            file: blank("file"),
            lot: text(row, "lot"),
            time: number(row, "time"),
        };
        self.units.push(OfUnit {
            unit,
            verdict: text(row, "verdict"),
            effects: texts(row, "effects"),
            unit_of_measure: blank("unit_of_measure"),
            noise: deviation("noise"),
            left: deviation("rms_after"),
            error: text(row, "error"),
        });
    }

    fn push_parameter(&mut self, row: &Row, numbers: &BTreeMap<String, usize>) {
        if text(row, "kind").as_deref() != Some(NAMED) {
            return;
        }
        let [unit, effect, parameter, measure] = ["unit", "effect", "parameter", "unit_of_measure"]
            .map(|column| text(row, column).unwrap_or_default());
        let (Some(value), Some(error)) = (number(row, "value"), number(row, "standard_error")) else {
            return;
        };
        if let Some(unit) = numbers.get(&unit).filter(|_| error > 0.0) {
            self.named
                .entry((effect, parameter, measure))
                .or_default()
                .push((*unit, Estimate { value, error }));
        }
    }
}
