//! The help of the single programs, with the names that hold behind the front door.

use clap::Command;
use clap::builder::StyledStr;

/// What a single program's command is called here. Only whole commands are renamed: the words stand at the
/// beginning of an example's line, behind a backtick or a pipe.
const NAMES: [(&str, &str); 8] = [
    ("fitter ", "arcsmith "),
    ("twin ", "arcsmith "),
    ("diagnose ", "arcsmith diagnose "),
    ("trials ", "arcsmith trials "),
    ("codegen check", "arcsmith check"),
    ("codegen explore", "arcsmith explore"),
    ("codegen verify", "arcsmith verify"),
    ("codegen", "arcsmith generate"),
];
/// Where the examples of `completions` put them.
const PLACES: [(&str, &str); 2] =
    [("completions/fitter", "completions/arcsmith"), ("/_fitter", "/_arcsmith")];
const BEFORE: [&str; 3] = ["\n  ", "`", "| "];

/// The command and all below it, with the help renamed.
pub(crate) fn renamed(mut command: Command) -> Command {
    if let Some(help) = command.get_after_help().map(text) {
        command = command.after_help(help);
    }
    if let Some(about) = command.get_about().map(text) {
        command = command.about(about);
    }
    if let Some(about) = command.get_long_about().map(text) {
        command = command.long_about(about);
    }
    command = command.mut_args(|argument| match argument.get_help().map(text) {
        Some(help) => argument.help(help),
        None => argument,
    });
    let names: Vec<String> = command.get_subcommands().map(|below| below.get_name().to_string()).collect();
    names.iter().fold(command, |command, name| command.mut_subcommand(name, renamed))
}

fn text(styled: &StyledStr) -> String {
    let mut text = styled.to_string();
    for (place, here) in PLACES {
        text = text.replace(place, here);
    }
    for (name, here) in NAMES {
        for before in BEFORE {
            text = text.replace(&format!("{before}{name}"), &format!("{before}{here}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::text;

    #[test]
    fn commands_are_renamed_and_words_are_not() {
        let renamed = text(
            &"Examples:\n  codegen\n  codegen check --out a\n  fitter man | man -l -\nas `fitter fit` wrote"
                .into(),
        );
        assert_eq!(
            renamed,
            "Examples:\n  arcsmith generate\n  arcsmith check --out a\n  arcsmith man | man -l -\nas `arcsmith fit` wrote"
        );
        assert_eq!(text(&"the fitter and its twin".into()), "the fitter and its twin");
    }
}
