//! The text of a project file as a tree whose every part knows its line.

use std::collections::BTreeMap;

use fitter::message::Message;
use fitter::table::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::FILE;
use crate::terminal::Result;

/// A value and the line on which it stands.
#[derive(Debug, Clone)]
pub struct Entry {
    pub line: usize,
    pub item: Item,
}

/// What a value is.
#[derive(Debug, Clone)]
pub enum Item {
    Bool(bool),
    /// A number, as it is written.
    Number(String),
    Text(String),
    List(Vec<Entry>),
    Table(Table),
    /// A date or a time, which no key of a project is.
    Other(String),
}

/// Keys and their values.
pub type Table = BTreeMap<String, Entry>;

/// Parses the text of a project file.
pub fn parse(text: &str) -> Result<Table> {
    let parsed = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or(1, |span| line(text, span.start));
        refuse(at, format!("is not TOML ({})", error.message())).mend("correct the line")
    })?;
    Ok(table(text, parsed.get_ref()))
}

/// A message about a line of the file.
pub fn refuse(line: usize, what: impl std::fmt::Display) -> Message {
    Message::of(what).at(FILE).line(line)
}

fn line(text: &str, at: usize) -> usize {
    1 + text[..at.min(text.len())].matches('\n').count()
}

fn table(text: &str, table: &DeTable) -> Table {
    let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue>)| {
        let key: &Spanned<std::borrow::Cow<str>> = key;
        let line = line(text, key.span().start);
        (key.get_ref().to_string(), Entry { line, item: item(text, value) })
    };
    table.iter().map(entry).collect()
}

fn item(text: &str, value: &Spanned<DeValue>) -> Item {
    // As it is written, since `1.5259e-5` is to stand so in the head of what is generated.
    let written = || text.get(value.span()).unwrap_or_default().replace('_', "");
    match value.get_ref() {
        DeValue::String(text) => Item::Text(text.to_string()),
        DeValue::Integer(_) | DeValue::Float(_) => Item::Number(written()),
        DeValue::Boolean(value) => Item::Bool(*value),
        DeValue::Datetime(value) => Item::Other(value.to_string()),
        DeValue::Array(values) => {
            let entry = |value: &Spanned<DeValue>| Entry {
                line: line(text, value.span().start),
                item: item(text, value),
            };
            Item::List(values.iter().map(entry).collect())
        }
        DeValue::Table(inner) => Item::Table(table(text, inner)),
    }
}

impl Entry {
    /// The refusal of this value of `key`.
    pub fn wrong(&self, key: &str, expected: impl std::fmt::Display) -> Message {
        let found = self.item.to_string();
        refuse(self.line, format!("`{key}`")).found(found).expected(expected).mend("correct it")
    }

    /// A text that is not blank.
    pub fn text(&self, key: &str) -> Result<String> {
        match &self.item {
            Item::Text(text) if !text.trim().is_empty() => Ok(text.clone()),
            _ => Err(self.wrong(key, "a text in quotes")),
        }
    }

    /// One text, or a list of them.
    pub fn texts(&self, key: &str) -> Result<Vec<String>> {
        match &self.item {
            Item::List(items) => items.iter().map(|item| item.text(key)).collect(),
            _ => Ok(vec![self.text(key)?]),
        }
    }

    /// A table.
    pub fn table(&self, key: &str) -> Result<&Table> {
        match &self.item {
            Item::Table(table) => Ok(table),
            _ => Err(self.wrong(key, format!("a table, [{key}]"))),
        }
    }
}

impl std::fmt::Display for Item {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Item::Bool(value) => value.fmt(f),
            Item::Number(text) | Item::Other(text) => text.fmt(f),
            Item::Text(text) => write!(f, "\"{text}\""),
            Item::List(items) => write!(f, "a list of {}", items.len()),
            Item::Table(_) => write!(f, "a table"),
        }
    }
}

/// Refuses keys that are not among the known ones, with the nearest; `of` is the table, for the message.
pub fn check_keys(table: &Table, of: &str, known: &[&str]) -> Result<()> {
    let Some((key, entry)) = table.iter().find(|(key, _)| !known.contains(&key.as_str())) else {
        return Ok(());
    };
    let whole = if of.is_empty() { key.clone() } else { format!("{of}.{key}") };
    let names: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    let mend = nearest(key, known.iter().copied()).map(|near| format!("did you mean `{near}`?"));
    Err(refuse(entry.line, format!("unknown key `{whole}`"))
        .expected(format!("one of {}", names.join(", ")))
        .mend(mend.unwrap_or_else(|| "remove it".into())))
}
