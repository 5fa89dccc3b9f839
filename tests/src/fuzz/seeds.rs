//! Undamaged inputs, which the program under test writes itself.

use std::collections::BTreeMap;
use std::path::Path;

use super::kept;
use super::options::Options;
use super::process::{Limits, run};
use super::table::Table;
use super::{bytes, written};

/// Files by name, and the options of every command.
#[derive(Debug)]
pub struct Seeds {
    /// The files.
    pub files: BTreeMap<String, Vec<u8>>,
    /// The options.
    pub options: Options,
}

/// Nominal plants of the mechanism that `excite` drives.
const PLANT: &str = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n\
    damping = 34.5\nstiffness = 54735.7\ngain = 742151165.8\nhold = \"band-limited\"\n";
const FRICTION: &str = "\n[[effects]]\nid = \"coulomb_friction\"\nforce_per_inertia = 601721.4\n";

/// Commands that write recordings of forty to a hundred rows (of moving mechanisms the 200 that a diagnosis needs),
/// and what comes of them; `thin FILE n m` keeps one row of n, m at most.
const STEPS: &str = include_str!("../../fuzz/seeds.txt");

/// What is run on them: a weight, how often it is drawn, and the command line. Words that name seeds stand for their
/// files. `verify` and `trials` are left out: they take minutes by design, and read nothing that the others do not.
const COMMANDS: &str = include_str!("../../fuzz/commands.txt");

/// The command lines with their weights.
pub fn commands() -> impl Iterator<Item = (usize, &'static str)> {
    COMMANDS
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(weight, line)| (weight.parse().unwrap_or(1), line))
}

impl Seeds {
    /// Makes them with `program`.
    ///
    /// # Errors
    /// The step that failed, with its message; or that a file could not be read.
    pub fn make(program: &Path) -> Result<Seeds, String> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let at = |name: &str| folder.path().join(name);
        let put =
            |name: &str, bytes: &[u8]| std::fs::write(at(name), bytes).map_err(|e| format!("{name}: {e}"));
        let get = |name: &str| std::fs::read(at(name)).map_err(|error| format!("{name}: {error}"));
        let call = |words: &[&str]| -> Result<Vec<u8>, String> {
            let words: Vec<_> = words.iter().map(Into::into).collect();
            let outcome = run(program, folder.path(), &words, Limits::GENEROUS, false)
                .map_err(|error| error.to_string())?;
            match outcome.code {
                Some(0) => Ok(outcome.stdout),
                _ => Err(format!(
                    "arcsmith {}: {}",
                    kept::quoted(&words),
                    String::from_utf8_lossy(&outcome.stderr)
                )),
            }
        };
        put("plant.toml", PLANT.as_bytes())?;
        put("friction.plant.toml", format!("{PLANT}{FRICTION}").as_bytes())?;
        for line in STEPS.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["thin", name, step, rows] => {
                    let (step, rows) = (step.parse().unwrap_or(1), rows.parse().unwrap_or(1));
                    put(name, &Table::parse(&get(name)?).thinned(step, rows).plain())?;
                }
                _ => drop(call(&words)?),
            }
        }
        let simulated =
            String::from_utf8_lossy(&get("sim.csv")?).replacen("angle_arcsec", "reference_arcsec", 1);
        put("sim.csv", simulated.as_bytes())?;
        put("warm.json", &get("warm.coefficients.json")?)?;
        put("cal.csv.gz", &bytes::gz(&get("cal.csv")?))?;
        put("cal.parquet", &Table::parse(&get("cal.csv")?).parquet().ok_or("cal.csv: no Parquet")?)?;
        let mut options = Options::default();
        for (_, line) in commands() {
            let command = line.split(' ').next().unwrap_or_default();
            options.learn(command, &String::from_utf8_lossy(&call(&[command, "-h"])?));
        }
        let files = written::files(folder.path())?;
        let files =
            files.into_iter().filter_map(|(path, kind)| Some((path.to_str()?.to_string(), kind.bytes()?)));
        Ok(Seeds { files: files.collect(), options })
    }

    /// The files that a word of a command line names: the one of that name, or all in the folder of that name.
    pub fn named<'a>(&'a self, word: &str) -> impl Iterator<Item = (&'a String, &'a Vec<u8>)> {
        let (name, folder) = (word.to_string(), format!("{word}/"));
        self.files.iter().filter(move |(path, _)| **path == name || path.starts_with(&folder))
    }
}
