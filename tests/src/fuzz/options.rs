//! Damage to the command line. What options a command has, its own help says.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;

use super::draw::Draw;

/// Values with a structure of their own, for whatever option.
const STRUCTURED: &str = "x1_mm=x2_mm x1_mm=x1_mm:furlong measured=measured:99bit =: \
    temperature_c=15..35:counts:12:0.05:-400 temperature_c=15..35:counts:31:1e300:0 temperature_c=35..15 \
    temperature_c=-1e300..1e300 temperature_c=20..20 1x8 0x0 99x2 2x64 1e-300arcsec 0.1arcsec 1mm -1deg stdint int \
    thermal_lag:coefficient_arcsec_per_k=1e300,time_constant_s=1 thermal_lag: 1,2,2";

/// Options whose cost grows with their number, as their user asks: they get small numbers only.
const COUNTS: [&str; 7] =
    ["--splits", "--samples", "--periods", "--runs", "--turns", "--passes", "--readings"];

/// Options that make a search of minutes of any command.
const SEARCHES: [&str; 2] = ["--target", "--demo"];

/// An option and the values that the help lists for it; `None` where it takes none.
type Known = (String, Option<Vec<String>>);

/// The options of every command.
#[derive(Debug, Default)]
pub struct Options(BTreeMap<String, Vec<Known>>);

impl Options {
    /// Learns those of a command from its `-h`.
    pub fn learn(&mut self, command: &str, help: &str) {
        let options = help.lines().filter_map(|line| {
            let (option, rest) =
                line.trim_start().split_once("--").map(|(_, rest)| rest.split_once([' ', '\n']))??;
            let values = rest.split_once("[possible values: ").and_then(|(_, rest)| rest.split_once(']'));
            let values =
                values.map_or_else(Vec::new, |(list, _)| list.split(", ").map(str::to_string).collect());
            let listed = line.trim_start().starts_with('-') && !SEARCHES.contains(&&*format!("--{option}"));
            listed.then(|| (format!("--{option}"), rest.starts_with('<').then_some(values)))
        });
        self.0.insert(command.to_string(), options.collect());
    }

    /// The command of a command line, or that there is none.
    pub fn command(&self, line: &[OsString]) -> &str {
        let known = line.first().and_then(|word| self.0.get_key_value(&*word.to_string_lossy()));
        known.map_or("(none)", |(name, _)| name)
    }

    /// Damages a command line once; `files` are names of inputs.
    pub fn damage(&self, draw: &mut Draw, line: &mut Vec<OsString>, files: &[String]) {
        let Some(command) = line.first() else { return };
        let known = self.0.get(&*command.to_string_lossy()).map_or(&[][..], Vec::as_slice);
        let valued: Vec<usize> = (1..line.len().saturating_sub(1))
            .filter(|&at| line[at].to_string_lossy().starts_with("--"))
            .filter(|&at| !line[at + 1].to_string_lossy().starts_with("--"))
            .collect();
        match draw.below(10) {
            0 => drop(line.remove(draw.below(line.len()))),
            1 => line.push(draw.pick(line).clone()),
            2 => {
                let at = draw.below(line.len());
                line[at] = value(draw, "", &[], files);
            }
            3..=5 if !known.is_empty() => {
                let (option, values) = draw.pick(known);
                line.push(option.into());
                if let Some(values) = values {
                    line.push(value(draw, option, values, files));
                }
            }
            _ if !valued.is_empty() => {
                let at = *draw.pick(&valued);
                let option = line[at].to_string_lossy().into_owned();
                let values =
                    known.iter().find(|(name, _)| *name == option).and_then(|(_, values)| values.as_deref());
                line[at + 1] = value(draw, &option, values.unwrap_or_default(), files);
            }
            _ => line.push(value(draw, "", &[], files)),
        }
    }
}

/// A value for an option. Paths stay within the folder: what a command may write, it writes there.
fn value(draw: &mut Draw, option: &str, values: &[String], files: &[String]) -> OsString {
    if COUNTS.contains(&option) {
        return draw.pick(&["0", "1", "2", "7", "-3", "1e3", "nan", "2.5", "1e-9"]).into();
    }
    match draw.below(12) {
        0 => draw.text().replace('\0', "").into(),
        1 => OsString::from_vec(b"b\xff".to_vec()),
        2 => draw
            .pick(&["", ".", "folder/..", "nowhere/file.json", "full", "folder", "folder/", "-", "--"])
            .into(),
        3 if !files.is_empty() => draw.pick(files).into(),
        4 | 5 => draw.part(STRUCTURED, ' ').into(),
        6..=8 if !values.is_empty() => draw.pick(values).into(),
        _ => draw.number().into(),
    }
}
