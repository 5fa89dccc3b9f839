//! Tables of options: in `[fit]` or `[[generate]]` every key is the option of that name of the command, as its help has it.

use clap::error::{ContextKind, ContextValue};
use clap::{ArgAction, Command, CommandFactory, Parser};

use super::tree::{self, Entry, Item, Table};
use crate::Cli;
use crate::terminal::Result;

/// An option that a project gives to a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The argument's id in the definition of the command.
    pub id: String,
    /// What stands for it in a command line.
    pub words: Vec<String>,
    /// Whether it is known by its place.
    pub positional: bool,
    /// The line of the project file, 0 where it is no option of a table.
    pub line: usize,
}

impl Given {
    /// An option and its value.
    pub fn option(id: &str, value: &str) -> Given {
        Given { id: id.into(), words: with_value(&id.replace('_', "-"), value), positional: false, line: 0 }
    }

    /// Values known by their place.
    pub fn places(id: &str, values: &[String]) -> Given {
        Given { id: id.into(), words: values.to_vec(), positional: true, line: 0 }
    }
}

/// `--name value`, in one word where the value could pass for an option.
fn with_value(name: &str, value: &str) -> Vec<String> {
    if value.starts_with('-') {
        vec![format!("--{name}={value}")]
    } else {
        vec![format!("--{name}"), value.to_string()]
    }
}

/// What a project says elsewhere, or what does not belong in it: no keys of a table.
const ELSEWHERE: [&str; 15] = [
    "mirror",
    "plant",
    "map",
    "effects",
    "coefficients",
    "recording",
    "json",
    "quiet",
    "verbose",
    "max_bytes",
    "max_columns",
    "demo",
    "pages_for",
    "check",
    "sweep",
];

/// What only the table of a target says.
const OF_A_TARGET: [&str; 3] = ["devices", "margin", "page_address"];

/// The options of the table of a command; `out_too` where it may say where that writes.
pub fn read(table: &Table, command: &str, out_too: bool) -> Result<Vec<Given>> {
    let program = Cli::command();
    let Some(definition) = program.find_subcommand(command) else { return Ok(Vec::new()) };
    let known: Vec<&str> = (definition.get_opts())
        .map(|arg| arg.get_id().as_str())
        .filter(|id| !ELSEWHERE.contains(id) && (out_too || *id != "out"))
        .filter(|id| command == "generate" || !OF_A_TARGET.contains(id))
        .collect();
    tree::check_keys(table, command, &known)?;
    let mut options = Vec::new();
    for (id, entry) in table {
        let words = words(definition, command, id, entry)?;
        if !words.is_empty() {
            options.push(Given { id: id.clone(), words, positional: false, line: entry.line });
        }
    }
    Ok(options)
}

/// The words of one option.
fn words(definition: &Command, command: &str, id: &str, entry: &Entry) -> Result<Vec<String>> {
    let key = format!("{command}.{id}");
    let arg = definition.get_opts().find(|arg| arg.get_id() == id);
    let name = arg.and_then(|arg| arg.get_long()).unwrap_or(id);
    let is_flag = arg.is_some_and(|arg| matches!(arg.get_action(), ArgAction::SetTrue));
    let several = arg.is_some_and(|arg| matches!(arg.get_action(), ArgAction::Append));
    match &entry.item {
        Item::Bool(wanted) if is_flag => Ok(if *wanted { vec![format!("--{name}")] } else { Vec::new() }),
        _ if is_flag => Err(entry.wrong(&key, "true or false")),
        Item::Number(text) | Item::Text(text) => Ok(with_value(name, text)),
        Item::List(items) if several => {
            let one = |item: &Entry| match &item.item {
                Item::Number(text) | Item::Text(text) => Ok(with_value(name, text)),
                _ => Err(item.wrong(&key, "a number or a text")),
            };
            Ok(items.iter().map(one).collect::<Result<Vec<_>>>()?.concat())
        }
        _ => Err(entry.wrong(&key, if several { "a text or a list of them" } else { "a number or a text" })),
    }
}

/// Refuses options that the command itself refuses, with the line of the one that it means.
pub fn check(command: &str, given: &[Given], line: usize) -> Result<()> {
    let words = given.iter().flat_map(|one| one.words.iter().map(String::as_str));
    let Err(error) = Cli::try_parse_from(["arcsmith", command].into_iter().chain(words)) else {
        return Ok(());
    };
    let named = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(name)) => name.clone(),
        Some(ContextValue::Strings(names)) => names.join(" "),
        _ => String::new(),
    };
    let named = named.split([' ', '=']).find_map(|word| word.strip_prefix("--")).unwrap_or_default();
    let meant = given.iter().find(|one| one.id.replace('_', "-") == named);
    let text = error.to_string();
    let text = text.trim_start_matches("error: ");
    let said = text.split_once("\n\n").map_or(text, |(first, _)| first);
    let said = said.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let line = meant.map_or(line, |one| one.line).max(1);
    Err(tree::refuse(line, format!("`{command}` refuses its options: {said}")).mend("correct the table"))
}
