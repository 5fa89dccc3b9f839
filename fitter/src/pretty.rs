//! JSON as a person would lay it out: objects over several lines, arrays of plain values on one.

use std::io::{Result, Write};

use serde_json::ser::Formatter;

/// See the module.
#[derive(Default)]
pub(crate) struct Pretty {
    /// One entry per open object or array.
    open: Vec<Level>,
}

struct Level {
    array: bool,
    /// An array whose entries stand on lines of their own.
    spread: bool,
    empty: bool,
}

impl Pretty {
    fn line<W: ?Sized + Write>(&self, writer: &mut W) -> Result<()> {
        writer.write_all(b"\n")?;
        (0..self.open.len()).try_for_each(|_| writer.write_all(b"  "))
    }

    /// An object or array begins: inside an array it starts a line.
    fn begin<W: ?Sized + Write>(&mut self, writer: &mut W, array: bool, sign: &[u8]) -> Result<()> {
        if let Some(level) = self.open.last_mut().filter(|level| level.array) {
            level.spread = true;
            self.line(writer)?;
        }
        self.open.push(Level { array, spread: !array, empty: true });
        writer.write_all(sign)
    }

    fn end<W: ?Sized + Write>(&mut self, writer: &mut W, sign: &[u8]) -> Result<()> {
        if self.open.pop().is_some_and(|level| level.spread && !level.empty) {
            self.line(writer)?;
        }
        writer.write_all(sign)
    }

    fn filled(&mut self) {
        if let Some(level) = self.open.last_mut() {
            level.empty = false;
        }
    }
}

impl Formatter for Pretty {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.begin(writer, true, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.end(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        let spread = self.open.last().is_some_and(|level| level.spread);
        match (first, spread) {
            (true, _) => Ok(()),
            (false, true) => writer.write_all(b","),
            (false, false) => writer.write_all(b", "),
        }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> Result<()> {
        self.filled();
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.begin(writer, false, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.end(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> Result<()> {
        self.filled();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_arrays_stand_on_one_line_and_the_text_reads_back() {
        let value: serde_json::Value =
            serde_json::from_str(r#"{"a":[1,2.5],"b":[[1,0],[0,1]],"c":[{"d":"x"},{"d":[]}],"e":{}}"#)
                .unwrap();
        let mut text = Vec::new();
        let mut serializer = serde_json::Serializer::with_formatter(&mut text, Pretty::default());
        serde::Serialize::serialize(&value, &mut serializer).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
        let expected = "{\n  \"a\": [1, 2.5],\n  \"b\": [\n    [1, 0],\n    [0, 1]\n  ],\n  \"c\": [\n    {\n      \
                        \"d\": \"x\"\n    },\n    {\n      \"d\": []\n    }\n  ],\n  \"e\": {}\n}";
        assert_eq!(text, expected);
    }
}
