//! What stands in a folder, and whether text in it is safe to open, to compile and to show.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// What a path is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// A folder.
    Folder,
    /// A file with these bytes.
    File(Vec<u8>),
    /// A device, a pipe or a link.
    Other(std::fs::FileType),
}

impl Kind {
    /// The bytes of a file.
    pub fn bytes(self) -> Option<Vec<u8>> {
        match self {
            Kind::File(bytes) => Some(bytes),
            _ => None,
        }
    }
}

/// All that stands in a folder, by the path relative to it.
///
/// # Errors
/// Where it cannot be read.
pub fn files(folder: &Path) -> Result<BTreeMap<PathBuf, Kind>, String> {
    let mut found = BTreeMap::new();
    collect(folder, Path::new(""), &mut found).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(found)
}

fn collect(folder: &Path, below: &Path, found: &mut BTreeMap<PathBuf, Kind>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder.join(below))? {
        let entry = entry?;
        let (path, kind) = (below.join(entry.file_name()), entry.file_type()?);
        let kind = match () {
            () if kind.is_dir() => {
                collect(folder, &path, found)?;
                Kind::Folder
            }
            () if kind.is_file() => Kind::File(std::fs::read(entry.path())?),
            () => Kind::Other(kind),
        };
        found.insert(path, kind);
    }
    Ok(())
}

/// What is wrong with a file that was written, by what its name says that it holds.
pub fn wrong(path: &Path, bytes: &[u8]) -> Option<String> {
    let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
    if matches!(kind, "bin" | "gz") {
        return None;
    }
    if let Some(what) = unsafe_to_show(bytes) {
        return Some(what);
    }
    let text = &*String::from_utf8_lossy(bytes);
    // A picture is one whatever its name.
    let kind = if text.starts_with("<svg") { "svg" } else { kind };
    let leaves = match kind {
        "json" => return json(text).err(),
        // In C, the compiler sees it.
        "rs" | "g" => text.lines().any(|line| {
            let line = line.trim_start();
            line.contains("CANARY") && !line.starts_with("//") && !line.starts_with('#')
        }),
        "html" | "svg" => ["<script>CANARY", "<b CANARY"].iter().any(|canary| text.contains(canary)),
        "csv" => return not_finite(bytes),
        _ => false,
    };
    leaves.then(|| "holds text of the input outside of comments, literals and escapes".into())
}

/// What a terminal or an editor would obey instead of showing it: control characters other than the ends of lines
/// and tabs, and what reverses the direction of text.
pub fn unsafe_to_show(bytes: &[u8]) -> Option<String> {
    let Ok(text) = std::str::from_utf8(bytes) else { return Some("is no UTF-8".into()) };
    let found = text.chars().find(|character| match character {
        '\n' | '\t' => false,
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        _ => character.is_control(),
    });
    found.map(|character| format!("holds the character {character:?}"))
}

/// Whether a word or a cell of a text is a number that is not finite, as Rust prints it.
pub fn not_finite(text: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(text);
    let mut words = text.split([' ', '\n', ',']);
    words.find(|word| matches!(*word, "inf" | "-inf" | "NaN")).map(|word| format!("states {word}"))
}

/// Fields that say by null that there is none of them.
const ABSENT: &str = "recorded fraction_bits next_experiment default harmonics amplitudes directions left \
    slope zero reservation held_out_rms noise testing_error training_error";

/// JSON whose numbers are numbers: serde_json writes null for what is not finite.
///
/// # Errors
/// Where it does not parse, or holds a null where a number belongs.
pub fn json(text: &str) -> Result<(), String> {
    let value: Value = serde_json::from_str(text).map_err(|error| format!("is no JSON: {error}"))?;
    match null(&value, "") {
        Some(place) => Err(format!("holds null at {place}")),
        None => Ok(()),
    }
}

fn null(value: &Value, place: &str) -> Option<String> {
    match value {
        Value::Null => Some(place.to_string()),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(n, item)| null(item, &format!("{place}/{n}")))
        }
        Value::Object(fields) => fields
            .iter()
            .filter(|(name, value)| !(value.is_null() && ABSENT.split(' ').any(|absent| *absent == **name)))
            .find_map(|(name, value)| null(value, &format!("{place}/{name}"))),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_leaves_its_place_is_seen() {
        let wrong = |name: &str, text: &str| wrong(Path::new(name), text.as_bytes()).is_some();
        assert!(!wrong("a.rs", "    /// */ CANARY") && wrong("a.rs", "// a\nCANARY();"));
        assert!(wrong("a.g", "# a\nCANARY"));
        assert!(wrong("a.html", "<p><script>CANARY</script>") && !wrong("a.html", "&lt;script>CANARY"));
        assert!(wrong("a.csv", "t_s\n-inf\n") && !wrong("a.csv", "t_s,info\n1,2\n"));
        assert!(wrong("a.csv", "a\u{202e}b") && wrong("a.svg", "\u{1b}[0m"));
        assert!(wrong("a.json", "{\"rms\": null}") && !wrong("a.json", "{\"recorded\": null}"));
        assert!(wrong("a.json", "{\"rms\": 1e999}") && wrong("a.json", "{\"rms\": NaN}"));
    }
}
