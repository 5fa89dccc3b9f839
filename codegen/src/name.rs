//! Names in generated source: which words may become one, and which already mean something there.

use crate::generate::GenerateError;
use crate::language;
use crate::options::Options;

/// Most characters of a name, those that C99 tells apart inside a file.
const LONGEST: usize = 63;

/// The base name of crate, files and functions: the one that was asked for, or the usual.
///
/// # Errors
/// [`GenerateError::Name`] of a word that no source can carry, [`GenerateError::ReservedName`] of one with a meaning of
/// its own.
pub fn base(options: &Options, usual: &str) -> Result<String, GenerateError> {
    let name = options.name.as_deref().unwrap_or(usual).to_string();
    if !is_identifier(&name) {
        return Err(GenerateError::Name { what: "the name", name });
    }
    match options.name.as_ref().and_then(|asked| reserved(asked)) {
        Some(why) => Err(GenerateError::ReservedName { name, why }),
        None => Ok(name),
    }
}

/// Whether a name can stand in generated source: a letter, then letters, digits and underscores, not too many, no keyword.
pub fn is_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    name.len() <= LONGEST
        && characters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !language::ALL.iter().any(|l| l.keywords().split_ascii_whitespace().any(|word| word == name))
}

/// What a name already means; none where it may be taken. File systems may not tell capitals from small letters.
fn reserved(name: &str) -> Option<&'static str> {
    let small = name.to_ascii_lowercase();
    let among = |words: &str| words.split_ascii_whitespace().any(|word| word == small);
    let everywhere = [
        (OWN, "a name inside the generated files"),
        (DEVICES, "a device on Windows, where no file can have its name"),
    ];
    if name.contains("__") || name.ends_with("_t") {
        return Some("reserved: C++ has the names with two underscores, POSIX those that end in _t");
    }
    let of_languages = language::ALL.iter().flat_map(|language| language.reserved().iter().copied());
    of_languages.chain(everywhere).find(|(words, _)| among(words)).map(|(_, why)| why)
}

/// Parameters, variables and helper functions of the templates.
const OWN: &str = "limit limit_f32 limit_i32 limit_i64 loaded constants constant high_word mul_add_high mul_high mul_short \
    mul_split phase_of shift_right to_signed around table row state result count coefficients page bytes s x1 x2 measured";

/// Names that Windows gives to devices.
const DEVICES: &str = "aux con nul prn com1 com2 com3 com4 com5 com6 com7 com8 com9 lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 \
    lpt9";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers() {
        assert!(is_identifier("corrected_angle") && is_identifier("mm"));
        assert!(!is_identifier("µm") && !is_identifier("9mm") && !is_identifier("fn") && !is_identifier(""));
        assert!(!is_identifier("_a") && !is_identifier("a b") && !is_identifier(&"a".repeat(64)));
    }

    #[test]
    fn a_name_that_means_something_is_not_taken_but_the_usual_ones_are() {
        for name in
            ["stdint", "StdInt", "math", "pthread", "abs", "core", "limit", "nul", "a__b", "angle_t", "lib"]
        {
            let options = Options { name: Some(name.into()), ..Options::default() };
            assert!(matches!(base(&options, "usual"), Err(GenerateError::ReservedName { .. })), "{name}");
        }
        for name in ["torque", "isolated", "string_angle", "axis_1", "corrected_angle"] {
            assert_eq!(reserved(name), None, "{name}");
        }
        // A direct sensor's unit may be anything that can be part of a name.
        assert_eq!(base(&Options::default(), "corrected_t").unwrap(), "corrected_t");
    }
}
