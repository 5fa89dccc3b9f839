//! What the arguments name as the input of a generation: a file, a recording, the embedded mirror, or the one
//! coefficients file of the folder. Nothing else is taken, so that nobody ships the demonstration by mistake.

use std::path::{Path, PathBuf};

use super::terminal::{line, say};
use super::{Arguments, Result};
use crate::refused;
use crate::source::Source;

/// The name that `fit` gives its file.
const USUAL: &str = "coefficients.json";
/// How the names of a diagnosis's files end.
const OF_A_DIAGNOSIS: &str = ".coefficients.json";

/// The source that is named, or else that is found in the current folder.
pub fn source(arguments: &Arguments) -> Result<Source> {
    match (&arguments.coefficients, &arguments.recording, &arguments.mirror) {
        (Some(path), _, _) => Ok(Source::Coefficients(path.clone())),
        (None, Some(recording), Some(mirror)) => {
            Ok(Source::Recording { recording: recording.clone(), mirror: mirror.clone() })
        }
        _ if arguments.demo || regenerates() => Ok(Source::Embedded),
        _ => found(Path::new("")).map(Source::Coefficients).map_err(|there| {
            refused!("nothing is named to generate from, and {there}").mend(
                "give --coefficients coefficients.json, or --recording with --mirror, or --demo for the embedded recording \
                 of a simulated mirror",
            )
        }),
    }
}

/// Whether this is the repository's own `cargo run -p codegen`, which regenerates what is committed there: cargo runs
/// this package, in the folder of its workspace.
fn regenerates() -> bool {
    let package = std::env::var("CARGO_PKG_NAME").is_ok_and(|name| name == env!("CARGO_PKG_NAME"));
    let workspace = std::env::var_os("CARGO_MANIFEST_DIR")
        .and_then(|manifest| Path::new(&manifest).parent().and_then(|folder| folder.canonicalize().ok()));
    let here = std::env::current_dir().and_then(|folder| folder.canonicalize()).ok();
    package && workspace.is_some() && workspace == here
}

/// The one coefficients file of a folder; else what is there instead, in words.
fn found(folder: &Path) -> Result<PathBuf, String> {
    let usual = folder.join(USUAL);
    if usual.is_file() {
        return Ok(usual);
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let names = std::fs::read_dir(here).map(|entries| {
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.ends_with(OF_A_DIAGNOSIS)).collect::<Vec<_>>()
    });
    let mut names = names.unwrap_or_default();
    names.sort();
    match &names[..] {
        [] => Err(format!("the folder has no {USUAL}")),
        [one] => Ok(folder.join(one)),
        several => Err(format!("the folder has no {USUAL} but {}", several.join(" and "))),
    }
}

/// What a command has to name so that it takes the same source anywhere; nothing where the user named it.
pub fn words_of(arguments: &Arguments) -> Result<Vec<String>> {
    let a = arguments;
    if a.coefficients.is_some() || a.recording.is_some() || a.demo || !a.devices.is_empty() {
        return Ok(Vec::new());
    }
    Ok(match source(arguments)? {
        Source::Embedded => vec!["--demo".into()],
        Source::Coefficients(path) => vec!["--coefficients".into(), path.display().to_string()],
        Source::Recording { .. } => Vec::new(),
    })
}

/// Says which file was taken where none was named.
pub fn tell(arguments: &Arguments) -> Result<()> {
    let common = arguments.common;
    if let [option, file] = &words_of(arguments)?[..]
        && option == "--coefficients"
        && !(common.quiet || common.json)
    {
        say(line("taken", &format!("{file}, which lies in this folder")).trim_end());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::found;
    use std::fs::write;

    #[test]
    fn one_coefficients_file_is_found_and_several_are_not_guessed_among() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert!(found(folder.path()).unwrap_err().ends_with("no coefficients.json"));
        write(at("slit.coefficients.json"), "").unwrap();
        write(at("other.json"), "").unwrap();
        assert_eq!(found(folder.path()).unwrap(), at("slit.coefficients.json"));
        write(at("axis.coefficients.json"), "").unwrap();
        let several = found(folder.path()).unwrap_err();
        assert!(several.ends_with("but axis.coefficients.json and slit.coefficients.json"), "{several}");
        write(at("coefficients.json"), "").unwrap();
        assert_eq!(found(folder.path()).unwrap(), at("coefficients.json"));
    }
}
