//! Messages in their parts: where, what was found, what was expected, how to mend it, and which value mends it.
//!
//! Libraries know values and their names, not how a user sets them. A program that has options for them says so:
//! [`Message::options`].

use std::fmt;

use serde::Serialize;

/// A message: `FILE, line N, column `C`: what is wrong, found …, expected …; how to mend it`, as far as it has these
/// parts. As JSON those are fields of their own.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Message(Box<Parts>);

#[derive(Debug, Clone, Default, PartialEq, Serialize)]
struct Parts {
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<String>,
    #[serde(skip)]
    what: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<String>,
    /// Whether what was found is shown in quotes.
    #[serde(skip)]
    quoted: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mend: Option<String>,
    /// The values that mend it, and what each is to be or is.
    #[serde(skip)]
    values: Vec<(&'static str, Option<String>)>,
}

/// An error that tells its message in parts.
pub trait InParts: std::error::Error {
    /// The message.
    fn message(&self) -> Message;
}

impl InParts for Message {
    fn message(&self) -> Message {
        self.clone()
    }
}

impl std::error::Error for Message {}

/// A file, and a line of it where it has lines.
pub type FileLine = (String, Option<u64>);

/// The file of a message, with or without line and column.
pub trait Where {
    /// The message with them.
    fn enter(&self, message: Message) -> Message;
}

impl Where for str {
    fn enter(&self, mut message: Message) -> Message {
        message.0.file = Some(self.to_string());
        message
    }
}

impl Where for String {
    fn enter(&self, message: Message) -> Message {
        self.as_str().enter(message)
    }
}

impl Where for FileLine {
    fn enter(&self, mut message: Message) -> Message {
        message.0.line = self.1;
        self.0.enter(message)
    }
}

impl Where for std::path::PathBuf {
    fn enter(&self, message: Message) -> Message {
        crate::text_safety::path(self).enter(message)
    }
}

impl Message {
    /// A message that says this.
    pub fn of(what: impl fmt::Display) -> Message {
        Message::default().says(what)
    }

    /// Where it is.
    #[must_use]
    pub fn at(self, place: &(impl Where + ?Sized)) -> Message {
        place.enter(self)
    }

    /// The line, the first being 1.
    #[must_use]
    pub fn line(mut self, line: impl TryInto<u64>) -> Message {
        self.0.line = line.try_into().ok();
        self
    }

    /// The column's name.
    #[must_use]
    pub fn column(mut self, column: impl fmt::Display) -> Message {
        self.0.column = Some(column.to_string());
        self
    }

    /// What is wrong.
    #[must_use]
    pub fn says(mut self, what: impl fmt::Display) -> Message {
        self.0.what = Some(what.to_string());
        self
    }

    /// Of what it is said.
    #[must_use]
    pub fn about(mut self, subject: impl fmt::Display) -> Message {
        let what = self.0.what.take().unwrap_or_default();
        self.says(format_args!("{subject}: {what}"))
    }

    /// What was found, in words.
    #[must_use]
    pub fn found(mut self, found: impl fmt::Display) -> Message {
        self.0.found = Some(found.to_string());
        self
    }

    /// What was found, as it stands there.
    #[must_use]
    pub fn cell(mut self, found: impl fmt::Display) -> Message {
        self.0.quoted = true;
        self.found(found)
    }

    /// What was expected.
    #[must_use]
    pub fn expected(mut self, expected: impl fmt::Display) -> Message {
        self.0.expected = Some(expected.to_string());
        self
    }

    /// How to mend it.
    #[must_use]
    pub fn mend(mut self, mend: impl fmt::Display) -> Message {
        self.0.mend = Some(mend.to_string());
        self
    }

    /// The name of the value that mends it.
    #[must_use]
    pub fn by(mut self, value: &'static str) -> Message {
        self.0.values.push((value, None));
        self
    }

    /// The same, and what it is to be, or is.
    #[must_use]
    pub fn by_setting(mut self, value: &'static str, to: impl fmt::Display) -> Message {
        self.0.values.push((value, Some(to.to_string())));
        self
    }

    /// The options that set the values of which it speaks: `option` tells that of a value's name.
    pub fn options(&self, option: impl Fn(&str) -> String) -> Vec<String> {
        let with = |to: &Option<String>| to.as_ref().map_or(String::new(), |to| format!(" {to}"));
        self.0.values.iter().map(|(value, to)| option(value) + &with(to)).collect()
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Parts { file, line, column, what, found, quoted, expected, mend, .. } = &*self.0;
        let rows = file.as_ref().is_some_and(|file| crate::table::counts_rows(file));
        let line = line.map(|line| format!("{} {line}", if rows { "row" } else { "line" }));
        let column = column.as_ref().map(|column| format!("column `{column}`"));
        let quote = if *quoted { "`" } else { "" };
        let found = found.as_ref().map(|found| format!("found {quote}{found}{quote}"));
        let expected = expected.as_ref().map(|expected| format!("expected {expected}"));
        let joined = |parts: [Option<String>; 3]| parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        let (place, statement) =
            (joined([file.clone(), line, column]), joined([what.clone(), found, expected]));
        let colon = if place.is_empty() || statement.is_empty() { "" } else { ": " };
        write!(f, "{place}{colon}{statement}")?;
        mend.as_ref().map_or(Ok(()), |mend| write!(f, "; {mend}"))
    }
}

/// Declares an error: each variant with its fields and the parts of its message, which are formatted as `format!` does;
/// then the errors that it passes on.
///
/// ```
/// fitter::errors! {
///     /// Why a degree is refused.
///     #[derive(Debug)]
///     pub enum DegreeError {
///         Large { file: String, found: usize } =>
///             at(file) found("degree {found}") expected("at most 24") mend("lower it") by(degree);
///     }
///     from { Recording(fitter::RecordingError) }
/// }
/// let error = DegreeError::Large { file: "a.json".into(), found: 30 };
/// assert_eq!(error.to_string(), "a.json: found degree 30, expected at most 24; lower it");
/// let options = fitter::message::Message::from(error).options(|value| format!("--{value}"));
/// assert_eq!(options, ["--degree"]);
/// ```
#[macro_export]
macro_rules! errors {
    // Errors whose text is what their message says.
    (plain $($name:ty),+ $(,)?) => { $(
        impl $crate::message::InParts for $name {
            fn message(&self) -> $crate::message::Message {
                $crate::message::Message::of(self)
            }
        }

        impl From<$name> for $crate::message::Message {
            fn from(error: $name) -> Self {
                $crate::message::Message::of(error)
            }
        }
    )+ };
    (@part $message:ident of($error:expr)) => { $crate::message::InParts::message($error) };
    (@part $message:ident at($place:expr)) => { $message.at($place) };
    (@part $message:ident line($line:expr)) => { $message.line(*$line) };
    (@part $message:ident column($column:expr)) => { $message.column($column) };
    (@part $message:ident by_name($value:expr)) => { $message.by($value) };
    (@part $message:ident by($value:ident)) => { $message.by(stringify!($value)) };
    (@part $message:ident by($value:ident = $to:expr)) => { $message.by_setting(stringify!($value), $to) };
    (@part $message:ident $part:ident($($text:tt)+)) => { $message.$part(format_args!($($text)+)) };
    (
        $(#[$about:meta])*
        pub enum $name:ident {
            $(
                $(#[$variant_about:meta])*
                $variant:ident $({ $($field:ident: $type:ty),+ $(,)? })? $(( $($item:ident: $item_type:ty),+ ))? =>
                    $($part:ident($($text:tt)+))+;
            )*
        }
        $(from { $($passed:ident($inner:ty)),+ $(,)? })?
    ) => {
        $(#[$about])*
        #[allow(missing_docs)] // the messages say what the fields are
        pub enum $name {
            $( $(#[$variant_about])* $variant $({ $($field: $type),+ })? $(( $($item_type),+ ))?, )*
            $($( $passed($inner), )+)?
        }

        impl $crate::message::InParts for $name {
            #[allow(unused_variables)]
            fn message(&self) -> $crate::message::Message {
                match self {
                    $( $name::$variant $({ $($field),+ })? $(( $($item),+ ))? => {
                        let message = $crate::message::Message::default();
                        $( let message = $crate::errors!(@part message $part($($text)+)); )+
                        message
                    } )*
                    $($( $name::$passed(inner) => $crate::message::InParts::message(inner), )+)?
                }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(&$crate::message::InParts::message(self), f)
            }
        }

        impl std::error::Error for $name {}

        impl From<$name> for $crate::message::Message {
            fn from(error: $name) -> Self {
                $crate::message::InParts::message(&error)
            }
        }

        $($( impl From<$inner> for $name {
            fn from(inner: $inner) -> $name {
                $name::$passed(inner)
            }
        } )+)?
    };
}

errors!(plain std::io::Error, serde_json::Error);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_stays_one_part_whatever_it_holds() {
        let message = Message::default()
            .at(&("a.csv".to_string(), Some(3)))
            .column("x1_mm")
            .cell("1, expected 2; 3")
            .expected("a number")
            .mend("correct the cell")
            .by("map");
        assert_eq!(
            message.to_string(),
            "a.csv, line 3, column `x1_mm`: found `1, expected 2; 3`, expected a number; correct the cell"
        );
        let parts = serde_json::json!({
            "file": "a.csv", "line": 3, "column": "x1_mm", "found": "1, expected 2; 3",
            "expected": "a number", "mend": "correct the cell",
        });
        assert_eq!(serde_json::to_value(&message).unwrap(), parts);
        assert_eq!(serde_json::to_value(Message::of("nothing is there")).unwrap(), serde_json::json!({}));
    }
}
