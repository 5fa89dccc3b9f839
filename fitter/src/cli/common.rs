//! What the command lines of all programs share: how much is said, in which colours, and how a run ends.

use std::io::Write;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::Args;
use miette::{Report, Result, miette};

use crate::text_safety;

pub use crate::summary::{FIGURE, LABEL, WARNING, line};

/// How much is said and read, for every command of every program.
#[derive(Args, Debug, Clone, Copy, Default)]
pub struct Common {
    /// Print the summary as JSON
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print everything that was found
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Read at most so many bytes of a file, decompressed [default: 1073741824]
    #[arg(long, global = true, value_name = "N")]
    pub max_bytes: Option<u64>,
    /// Read at most so many columns of a recording [default: 512]
    #[arg(long, global = true, value_name = "N")]
    pub max_columns: Option<u64>,
}

impl Common {
    /// Lets the limits of what is read hold in this process.
    pub fn limit(&self) {
        crate::input::limit(self.max_bytes, self.max_columns);
    }

    /// Whether someone watches standard error and wants to see how far the work is.
    pub fn watched(&self) -> bool {
        use std::io::IsTerminal;
        !self.quiet && std::io::stderr().is_terminal()
    }
}

/// Prints a line or several. That nobody reads them to the end (`| head`) is no error; any other failure is one of the
/// whole program, see [`program`].
pub fn say(text: &str) {
    print(&format!("{}\n", for_terminal(text)));
}

/// Prints JSON: what a terminal would obey is escaped as JSON has it.
pub fn say_json(json: &str) {
    print(&(text_safety::json(json) + "\n"));
}

/// Prints text as it is, with styles where a terminal shows them: what comes from outside was made safe before.
pub fn print(text: &str) {
    let mut output = anstream::stdout();
    remember(output.write_all(text.as_bytes()).and_then(|()| output.flush()));
}

/// Prints a warning, unless nothing is to be said.
pub fn warn(text: &str, common: Common) {
    if !common.quiet {
        complain(&format!("{WARNING}warning:{WARNING:#} {text}"));
    }
}

/// Prints a line on standard error; where that fails there is nobody left to tell.
pub fn complain(text: &str) {
    let _ = writeln!(anstream::stderr(), "{}", for_terminal(text));
}

/// Why standard output could not be written, for the end of the program.
static UNWRITTEN: OnceLock<std::io::Error> = OnceLock::new();

fn remember(written: std::io::Result<()>) {
    match written {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => drop(UNWRITTEN.set(error)),
        _ => {}
    }
}

/// The text with everything escaped that a terminal obeys, but for ends of lines and the styles of this program's own.
fn for_terminal(text: &str) -> String {
    let help = clap::builder::Styles::styled();
    let own = [
        FIGURE,
        LABEL,
        WARNING,
        *help.get_header(),
        *help.get_error(),
        *help.get_valid(),
        *help.get_invalid(),
    ];
    let mut styles = own.map(|style| style.render().to_string()).to_vec();
    styles.extend([help.get_literal().render().to_string(), FIGURE.render_reset().to_string()]);
    let mut safe = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(['\n', '\x1b']) {
        safe += &text_safety::visible(&rest[..at]);
        let own = styles.iter().find(|style| rest[at..].starts_with(style.as_str()));
        let as_it_is = own.map_or(usize::from(rest[at..].starts_with('\n')), String::len);
        safe += &rest[at..at + as_it_is];
        rest = &rest[at + as_it_is..];
        if as_it_is == 0 {
            safe += &text_safety::visible("\x1b");
            rest = &rest[1..];
        }
    }
    safe + &text_safety::visible(rest)
}

/// Prints a summary as JSON or for people.
pub fn summarise(common: Common, json: impl FnOnce() -> serde_json::Value, people: impl FnOnce() -> String) {
    match (common.json, common.quiet) {
        (true, _) => say_json(&format!("{:#}", json())),
        (false, false) => say(people().trim_end()),
        (false, true) => {}
    }
}

/// Runs a program: its body with the arguments, or the help that they ask for, and the message of what went wrong; 2 is
/// the exit code of bad input, and of output that cannot be written.
pub fn program<A>(parsed: Result<A, clap::Error>, run: impl FnOnce(A) -> Result<ExitCode>) -> ExitCode {
    // Messages are one sentence each and stand on one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(refused) if refused.use_stderr() => {
            complain(refused.render().ansi().to_string().trim_end());
            return ExitCode::from(BAD_INPUT);
        }
        Err(help) => {
            print(&help.render().ansi().to_string());
            return ended(ExitCode::SUCCESS);
        }
    };
    match run(arguments) {
        Ok(code) => ended(code),
        Err(report) => refused(&report),
    }
}

const BAD_INPUT: u8 = 2;

/// The exit code, if all that was said was written.
fn ended(code: ExitCode) -> ExitCode {
    match UNWRITTEN.get() {
        None => code,
        Some(error) => refused(&miette!(
            "standard output cannot be written ({error}); make room there, or redirect it elsewhere"
        )),
    }
}

/// Prints a message, with its causes, for people: what of it comes from outside does nothing, and is cut to a length
/// that can be read.
fn refused(report: &Report) -> ExitCode {
    let readable = |message: String| {
        let safe = message.lines().map(text_safety::visible).collect::<Vec<_>>().join("\n");
        shortened(&safe, LONGEST_MESSAGE)
    };
    let mut messages: Vec<String> = report.chain().map(|error| readable(error.to_string())).collect();
    let innermost = messages.pop().unwrap_or_default();
    let report = messages.into_iter().rfold(Report::msg(innermost), Report::wrap_err);
    let _ = writeln!(std::io::stderr(), "{report:?}");
    ExitCode::from(BAD_INPUT)
}

/// Most characters of a message, of which a third are its end, where it says how to mend what is wrong.
const LONGEST_MESSAGE: usize = 3000;

fn shortened(text: &str, most: usize) -> String {
    let length = text.chars().count();
    if length <= most {
        return text.to_string();
    }
    let at = |number: usize| text.char_indices().nth(number).map_or(text.len(), |(at, _)| at);
    let (begin, end) = (at(most - most / 3), at(length - most / 3));
    format!("{} … ({} characters left out) … {}", &text[..begin], length - most, &text[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_obeys_this_programs_styles_only() {
        let own = format!("{WARNING}warning:{WARNING:#} a\nb");
        assert_eq!(for_terminal(&own), own);
        assert_eq!(
            for_terminal("\x1b[8m\x1b]0;title\x07\r\u{202e}"),
            "\\u{1b}[8m\\u{1b}]0;title\\u{7}\\u{d}\\u{202e}"
        );
    }

    #[test]
    fn a_long_message_keeps_its_beginning_and_its_end() {
        assert_eq!(shortened("abcdefghijklm", 9), "abcdef … (4 characters left out) … klm");
        assert_eq!(shortened("äbc", 3), "äbc");
    }
}
