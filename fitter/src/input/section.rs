//! Parts of the project file, `arcsmith.toml`: it may hold what otherwise stands in `mirror.toml`, `plant.toml` or a file of
//! effects, in the same tables. Whoever reads one of these files reads its tables from there too.

use std::path::Path;

use super::{FileError, parsed};

/// The name of the project file.
pub const PROJECT_FILE: &str = "arcsmith.toml";

/// The text of a TOML file, which is to be an `expected` one; of a project file these `tables` alone.
///
/// # Errors
/// As [`parsed`].
pub fn toml(path: &Path, expected: &'static str, tables: &[&str]) -> Result<String, FileError> {
    let text = parsed(path, expected)?;
    let is_project = path.file_name().is_some_and(|name| name == PROJECT_FILE);
    Ok(if is_project { section(&text, tables) } else { text })
}

/// The lines of these tables and of those below them; every other line is blank, so that numbers of lines stay.
pub fn section(text: &str, tables: &[&str]) -> String {
    let mut inside = false;
    let mut kept = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        if let Some(name) = header(line) {
            inside = tables.contains(&name);
        }
        kept += if inside { line } else { "\n" };
    }
    kept
}

/// The first name of a table's header: `geometry` of `[geometry]`, `plant` of `[[plant.effects]]`.
fn header(line: &str) -> Option<&str> {
    let line = line.split('#').next().unwrap_or(line).trim();
    let name = line.strip_prefix('[')?.strip_suffix(']')?;
    let name = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    let first = name.split('.').next().unwrap_or(name).trim().trim_matches('"');
    let plain = |sign: char| sign.is_ascii_alphanumeric() || sign == '_' || sign == '-';
    (first.starts_with(|sign: char| sign.is_ascii_alphabetic()) && first.chars().all(plain)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::section;

    #[test]
    fn the_lines_of_a_table_stay_where_they_are() {
        let text = "out = \"a\"\n[geometry] # d\ngap = 1\n[[generate]]\nlist = [\n  [1, 2],\n]\n[geometry.more]\nx = 2\n";
        assert_eq!(
            section(text, &["geometry"]),
            "\n[geometry] # d\ngap = 1\n\n\n\n\n[geometry.more]\nx = 2\n"
        );
        assert_eq!(section("[[effect]]\nid = \"a\"", &["effect"]), "[[effect]]\nid = \"a\"");
    }
}
