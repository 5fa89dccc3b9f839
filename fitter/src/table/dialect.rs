//! How a text file separates its columns and writes its decimal sign: recognised from its beginning.

/// What was recognised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dialect {
    /// Between the columns: a comma, a semicolon or a tab.
    pub delimiter: u8,
    /// Whether numbers have a comma in the place of the decimal point.
    pub decimal_comma: bool,
}

impl Dialect {
    /// Commas and points, as the recording format has them.
    pub const PLAIN: Dialect = Dialect { delimiter: b',', decimal_comma: false };

    /// Recognises the dialect from the first bytes of a file, comments left out: the delimiter is the most frequent candidate of the
    /// header, and where it is not the comma itself, numbers with a comma and none with a point mean that the comma
    /// is the decimal sign.
    pub fn of(head: &[u8]) -> Dialect {
        let mut lines = head.split(|byte| *byte == b'\n').filter(|line| !skipped(line));
        let Some(header) = lines.next() else { return Dialect::PLAIN };
        let count = |sign: u8| header.iter().filter(|byte| **byte == sign).count();
        // Of equally frequent ones the first: the comma.
        let delimiter = [b',', b';', b'\t'].into_iter().rev().max_by_key(|sign| count(*sign)).unwrap_or(b',');
        if delimiter == b',' || count(delimiter) == 0 {
            return Dialect::PLAIN;
        }
        let (mut commas, mut points) = (0, 0);
        for field in lines.flat_map(|line| line.split(|byte| *byte == delimiter)) {
            let field = field.trim_ascii();
            let number = |sign: u8| {
                let rest: Vec<u8> = field.iter().copied().filter(|byte| *byte != sign).collect();
                rest.len() + 1 == field.len()
                    && std::str::from_utf8(&rest).is_ok_and(|t| t.parse::<f64>().is_ok())
            };
            commas += usize::from(number(b','));
            points += usize::from(number(b'.'));
        }
        Dialect { delimiter, decimal_comma: commas > points }
    }

    /// The field with a point in the place of the decimal comma; none if it holds a point already, or needs
    /// more room than a number does.
    pub(super) fn plain<'b>(self, field: &[u8], room: &'b mut [u8; 64]) -> Option<&'b [u8]> {
        let room = room.get_mut(..field.len())?;
        for (to, from) in room.iter_mut().zip(field) {
            *to = match *from {
                b'.' => return None,
                b',' => b'.',
                other => other,
            };
        }
        Some(room)
    }
}

/// Whether a line says nothing: it is blank, or a comment.
fn skipped(line: &[u8]) -> bool {
    line.trim_ascii().is_empty() || line.starts_with(b"#")
}

impl std::fmt::Display for Dialect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let delimiter = match self.delimiter {
            b';' => "semicolons",
            b'\t' => "tabs",
            _ => "commas",
        };
        let sign = if self.decimal_comma { "a decimal comma" } else { "a decimal point" };
        write!(f, "columns separated by {delimiter}, numbers with {sign}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiter_and_decimal_sign() {
        let of = |text: &str| {
            let dialect = Dialect::of(text.as_bytes());
            (dialect.delimiter, dialect.decimal_comma)
        };
        assert_eq!(of("a,b,c\n1,2.5,3\n"), (b',', false));
        assert_eq!(of("a;b;c\r\n1;2,5;3\r\n"), (b';', true));
        assert_eq!(of("a;b;c\n1;2.5;3\n"), (b';', false));
        assert_eq!(of("a\tb\n1,5\t-2,5e-3\n"), (b'\t', true));
        assert_eq!(of("\n\na;b\n1;2\n"), (b';', false));
        assert_eq!(of("a b\n1 2\n"), (b',', false));
        assert_eq!(of("# a, b, c, d\na;b\n1;2,5\n"), (b';', true));
        // A name with a comma in it does not outvote the delimiter.
        assert_eq!(of("s, mm;t;u\n1,5;2;3\n"), (b';', true));
    }
}
