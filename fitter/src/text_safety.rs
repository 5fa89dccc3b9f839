//! Text from outside (names of columns, effects, units and files) on its way into generated source, pages, pictures and
//! terminals. Names that become part of something are refused where they are read ([`name`], [`sentence`]); what may be
//! called anything, a file for example, is shown escaped ([`shown`]).
//!
//! Allowed are letters and digits of any script, accents, the space, and the signs of print and of mathematics: no control
//! character, none that is invisible or turns the direction of text, and no mark that begins or ends a comment of C.

use std::ops::RangeInclusive;
use std::path::Path;

use thiserror::Error;

/// Most characters of a name.
pub const LONGEST_NAME: usize = 120;
/// Most characters of any other text in a file that is read again.
pub const LONGEST_SENTENCE: usize = 8000;
/// Most characters of a cell in a message.
const LONGEST_CELL: usize = 40;
/// Most characters of a command in the file that it wrote.
const LONGEST_COMMAND: usize = 4000;

/// Signs beside ASCII's and letters: Latin's, accents, typography, mathematics and technology, fullwidth forms. What
/// turns the direction of text or joins letters unseen lies between them.
const SIGNS: [RangeInclusive<char>; 9] = [
    '\u{a0}'..='\u{ac}',
    '\u{ae}'..='\u{ff}',
    '\u{300}'..='\u{36f}',
    '\u{2010}'..='\u{2027}',
    '\u{202f}'..='\u{205e}',
    '\u{2070}'..='\u{2bff}',
    '\u{3001}'..='\u{303f}',
    '\u{ff01}'..='\u{ff65}',
    '\u{ffe0}'..='\u{ffee}',
];
/// What begins or ends a comment of C, and the trigraph of the backslash, which draws the next line into it.
const COMMENT_MARKS: [&str; 3] = ["*/", "/*", "??/"];
/// Letters that show nothing.
const BLANK_LETTERS: [char; 4] = ['\u{115f}', '\u{1160}', '\u{3164}', '\u{ffa0}'];

/// Why a text is refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnsafeText {
    /// A character that is not allowed.
    #[error("holds the character U+{:04X}", u32::from(*.0))]
    Character(char),
    /// A mark that begins, ends or continues a comment of C.
    #[error("holds `{0}`, a comment mark of C")]
    CommentMark(&'static str),
    /// Too long.
    #[error("has {found} characters, at most {most} are allowed")]
    Long {
        /// Characters found.
        found: usize,
        /// Characters allowed.
        most: usize,
    },
}

/// Whether a name (of a column, an effect) may be used.
///
/// # Errors
/// [`UnsafeText`]: the first thing that is not allowed.
pub fn name(text: &str) -> Result<(), UnsafeText> {
    checked(text, LONGEST_NAME)
}

/// Whether `name` may become part of a name in generated source: ASCII letters, digits and underscores,
/// a letter first, at most 24 of them.
pub fn is_identifier(name: &str) -> bool {
    name.len() <= 24
        && name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|sign| sign.is_ascii_alphanumeric() || sign == '_')
}

/// Whether a text of a file that is read again may be used.
///
/// # Errors
/// As [`name`].
pub fn sentence(text: &str) -> Result<(), UnsafeText> {
    checked(text, LONGEST_SENTENCE)
}

fn checked(text: &str, most: usize) -> Result<(), UnsafeText> {
    if let Some(character) = text.chars().find(|c| !allowed(*c)) {
        return Err(UnsafeText::Character(character));
    }
    if let Some(mark) = COMMENT_MARKS.into_iter().find(|mark| text.contains(mark)) {
        return Err(UnsafeText::CommentMark(mark));
    }
    let found = text.chars().count();
    if found > most { Err(UnsafeText::Long { found, most }) } else { Ok(()) }
}

fn allowed(c: char) -> bool {
    let sign = || SIGNS.iter().any(|signs| signs.contains(&c));
    (c == ' ' || c.is_ascii_graphic() || c.is_alphanumeric() || sign()) && !BLANK_LETTERS.contains(&c)
}

/// The text with every character escaped that is not allowed: `\u{202e}`.
pub fn visible(text: &str) -> String {
    let escaped = |c: char| if allowed(c) { String::from(c) } else { c.escape_unicode().to_string() };
    text.chars().map(escaped).collect()
}

/// [`visible`], and comment marks of C as well. Of a text within [`LONGEST_SENTENCE`] the result is one that
/// [`sentence`] accepts, and itself where it was one.
pub fn shown(text: &str) -> String {
    visible(text).replace("*/", "*\\u{2f}").replace("/*", "/\\u{2a}").replace("??/", "??\\u{2f}")
}

/// JSON text with everything escaped that is not allowed: the same JSON.
pub fn json(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        if allowed(c) || c == '\n' {
            safe.push(c);
        } else {
            safe.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
        }
    }
    safe
}

/// A path as messages and provenance name it.
pub fn path(path: &Path) -> String {
    shown(&path.to_string_lossy())
}

/// The last part of a path, as provenance names it; the whole where there is none.
pub fn file_name(whole: &Path) -> String {
    whole.file_name().map_or_else(|| path(whole), |name| shown(&name.to_string_lossy()))
}

/// A cell for a message, cut to a length that a person reads.
pub fn cell(bytes: &[u8]) -> String {
    excerpt(&String::from_utf8_lossy(bytes), LONGEST_CELL)
}

/// A command as the file that it wrote names it.
pub fn command(text: &str) -> String {
    excerpt(text, LONGEST_COMMAND)
}

/// A word as a shell takes it; with characters that a terminal may obey, as `$'…'` (POSIX 2024) and their bytes in
/// octal.
pub fn shell_word(word: &str) -> String {
    let plain = |sign: char| sign.is_alphanumeric() || "-_./=:+,".contains(sign);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else if visible(word) == word {
        format!("'{}'", word.replace('\'', "'\\''"))
    } else {
        let byte = |byte: u8| match byte {
            b'\'' | b'\\' => format!("\\{}", char::from(byte)),
            b' '..=b'~' => char::from(byte).to_string(),
            _ => format!("\\{byte:03o}"),
        };
        format!("$'{}'", word.bytes().map(byte).collect::<String>())
    }
}

/// A line of a source for the terminal, where comment marks do nothing, cut to so many characters.
pub fn line(text: &str, most: usize) -> String {
    cut(visible(text), most)
}

/// [`shown`], cut to so many characters.
pub fn excerpt(text: &str, most: usize) -> String {
    cut(shown(text), most)
}

fn cut(safe: String, most: usize) -> String {
    match safe.char_indices().nth(most) {
        Some((at, _)) => safe[..at].to_string() + "…",
        None => safe,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn honest_names_pass_and_are_shown_as_they_are() {
        for text in [
            "temperature_c",
            "Probe 1 [µm]",
            "U*I (V·A)",
            "v [m/s]",
            "Größe",
            "e\u{301}",
            "温度 °C",
            "a<b & \"c\"",
        ] {
            assert_eq!(name(text), Ok(()), "{text}");
            assert_eq!(shown(text), text);
        }
    }

    #[test]
    fn what_could_act_is_refused_by_its_code_point_and_shown_escaped() {
        use UnsafeText::{Character, CommentMark, Long};
        for (text, why, escaped) in [
            ("a\u{202e}b", Character('\u{202e}'), "a\\u{202e}b"),
            ("a\0", Character('\0'), "a\\u{0}"),
            ("\x1b[31m", Character('\x1b'), "\\u{1b}[31m"),
            ("a\nb", Character('\n'), "a\\u{a}b"),
            ("\u{2066}", Character('\u{2066}'), "\\u{2066}"),
            ("\u{200b}", Character('\u{200b}'), "\\u{200b}"),
            ("\u{3164}", Character('\u{3164}'), "\\u{3164}"),
            ("\u{fffd}", Character('\u{fffd}'), "\\u{fffd}"),
            ("*/ int evil; /*", CommentMark("*/"), "*\\u{2f} int evil; /\\u{2a}"),
            ("a/*", CommentMark("/*"), "a/\\u{2a}"),
            ("what??/", CommentMark("??/"), "what??\\u{2f}"),
            ("/*/", CommentMark("*/"), "/\\u{2a}\\u{2f}"),
        ] {
            assert_eq!(name(text), Err(why), "{text:?}");
            assert_eq!(shown(text), escaped);
            assert_eq!(sentence(&shown(text)), Ok(()), "{text:?}");
        }
        assert_eq!(Character('\u{202e}').to_string(), "holds the character U+202E");
        assert_eq!(json("{\n\"a\": \"\u{202e}😀µ\"}"), "{\n\"a\": \"\\u202e\\ud83d\\ude00µ\"}");
        let long = "x".repeat(121);
        assert_eq!(name(&long), Err(Long { found: 121, most: 120 }));
        assert_eq!(excerpt(&long, 40), "x".repeat(40) + "…");
    }

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        assert_eq!(shell_word("a/b-1.csv"), "a/b-1.csv");
        assert_eq!(shell_word("my file's.csv"), "'my file'\\''s.csv'");
        assert_eq!(shell_word("it's\n\u{202e}.csv"), "$'it\\'s\\012\\342\\200\\256.csv'");
    }
}
