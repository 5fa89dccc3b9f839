//! What every command shares: how much is said, in which colours, how far the work is, and how a run ends.

use std::cell::RefCell;
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use anstyle::{AnsiColor, Style};
use clap::Args;
use fitter::message::Message;
use fitter::progress::Progress;
use fitter::text_safety;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use serde_json::json;

/// What a line is about.
pub const LABEL: Style = Style::new().dimmed();
/// The figure that matters.
pub const FIGURE: Style = AnsiColor::Green.on_default().bold();
/// What should be looked at.
pub const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// What a command ends with: one message where it is refused.
pub type Result<T, E = Message> = std::result::Result<T, E>;

/// A message that refuses, formatted as `format!` does.
#[macro_export]
macro_rules! refused {
    ($($text:tt)*) => { ::fitter::message::Message::of(format_args!($($text)*)) };
}

/// The option of every command that sets a value: it has the value's name, but for the range, whose ends are two.
fn option(value: &str) -> String {
    match value {
        "range" => "--from, --to".into(),
        value => format!("--{}", value.replace('_', "-")),
    }
}

/// How much is said and read, for every command.
#[derive(Args, Debug, Clone, Copy, Default)]
pub struct Common {
    /// Print the summary as JSON, and an error as JSON on standard error
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
        fitter::input::limit(self.max_bytes, self.max_columns);
    }

    /// Whether someone watches standard error and wants to see how far the work is.
    pub fn watched(&self) -> bool {
        !self.quiet && std::io::stderr().is_terminal()
    }

    /// Progress of `length` steps on standard error, where someone watches; `template` as `indicatif` has it.
    pub fn progress(&self, length: u64, template: &str) -> ProgressBar {
        if !self.watched() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(length);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        bar
    }
}

/// A progress bar that libraries tell how far they are.
pub struct Watched(pub ProgressBar);

impl Progress for Watched {
    fn doing(&self, what: &str) {
        self.0.set_message(what.to_string());
    }

    fn steps(&self, count: u64) {
        self.0.set_position(0);
        self.0.set_length(count);
    }

    fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }

    fn warn(&self, text: &str) {
        self.0.suspend(|| complain(text));
    }
}

/// One labelled line.
pub fn line(label: &str, content: &str) -> String {
    format!("{LABEL}{label:<12}{LABEL:#} {content}\n")
}

/// Prints a line or several. That nobody reads them to the end (`| head`) is no error; any other failure is one of the
/// whole program, see [`program`].
pub fn say(text: &str) {
    print(&format!("{}\n", for_terminal(text)));
}

/// Prints JSON: what a terminal would obey is escaped as JSON has it.
pub fn say_json(json: &str) {
    match &mut *held(&GATHERED) {
        Some(gathered) => gathered.extend(serde_json::from_str::<serde_json::Value>(json).ok()),
        None => print(&(text_safety::json(json) + "\n")),
    }
}

/// What was said as JSON while several commands run as one.
static GATHERED: Mutex<Option<Vec<serde_json::Value>>> = Mutex::new(None);

/// Runs `work` and gathers what it would print as JSON.
pub fn gathered<T>(work: impl FnOnce() -> T) -> (T, Vec<serde_json::Value>) {
    let before = held(&GATHERED).replace(Vec::new());
    let result = work();
    let said = std::mem::replace(&mut *held(&GATHERED), before);
    (result, said.unwrap_or_default())
}

/// What a lock holds, also where a thread ended badly while it had it: every value of these is whole.
fn held<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
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

thread_local! {
    /// What the program was called with, where another program holds it.
    static CALLED: RefCell<Option<Vec<OsString>>> = const { RefCell::new(None) };
    /// The words of the command that is run in place of the one that was typed.
    static RUNNING: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Runs `body` as a program that was called with these words: its own name or path first. Another program, such as Python,
/// holds this one so.
pub fn called_with<T>(words: Vec<OsString>, body: impl FnOnce() -> T) -> T {
    let before = (CALLED.replace(Some(words)), RUNNING.take());
    let result = body();
    CALLED.set(before.0);
    RUNNING.set(before.1);
    result
}

/// The words with which the program was called, its own name or path first.
pub fn called() -> Vec<OsString> {
    CALLED.with_borrow(Option::clone).unwrap_or_else(|| std::env::args_os().collect())
}

/// From now on the command line counts as these words, the program's name left out.
pub fn running(words: &[String]) {
    RUNNING.set(Some(words.to_vec()));
}

/// The words of the command line, the program's name left out: what files say of how they were made.
pub fn words() -> Vec<String> {
    let typed = || called().into_iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    RUNNING.with_borrow(Option::clone).unwrap_or_else(typed)
}

/// Runs a program: its body with the arguments, or the help that they ask for, and the message of what went wrong; 2 is
/// the exit code of bad input, and of output that cannot be written.
pub fn program<A>(parsed: Result<A, clap::Error>, run: impl FnOnce(A) -> Result<ExitCode>) -> ExitCode {
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(refused) if refused.use_stderr() => {
            let message = refused.render();
            match machine() {
                true => complain_as_json(first_paragraph(&message.to_string()), &Message::default(), &[]),
                false => complain(message.ansi().to_string().trim_end()),
            }
            return ExitCode::from(BAD_INPUT);
        }
        Err(help) => {
            print(&help.render().ansi().to_string());
            return ended(ExitCode::SUCCESS);
        }
    };
    match run(arguments) {
        Ok(code) => ended(code),
        Err(error) => refuse(&error),
    }
}

const BAD_INPUT: u8 = 2;

/// What clap says is wrong, without the usage that it shows beside.
fn first_paragraph(text: &str) -> &str {
    let text = text.trim_start_matches("error: ");
    text.split_once("\n\n").map_or(text, |(first, _)| first).trim_end()
}

/// Whether the output is for a machine, also where the arguments could not be read.
fn machine() -> bool {
    called().iter().any(|word| word == "--json")
}

/// The exit code, if all that was said was written.
fn ended(code: ExitCode) -> ExitCode {
    match UNWRITTEN.get() {
        None => code,
        Some(error) => refuse(&refused!(
            "standard output cannot be written ({error}); make room there, or redirect it elsewhere"
        )),
    }
}

/// A message with the options that set the values of which it speaks.
pub fn with_options(message: &Message) -> String {
    let options = message.options(option);
    let by = if options.is_empty() { String::new() } else { format!(" (give {})", options.join(", ")) };
    format!("{message}{by}")
}

/// Prints a message with its options: what of it comes from outside does nothing, and is cut to a length that can be read.
fn refuse(message: &Message) -> ExitCode {
    let text = with_options(message);
    let safe = text.lines().map(text_safety::visible).collect::<Vec<_>>().join("\n");
    let readable = shortened(&safe, LONGEST_MESSAGE);
    match machine() {
        true => complain_as_json(&readable, message, &message.options(option)),
        false => {
            let style = clap::builder::Styles::styled();
            let label = style.get_error();
            let _ = writeln!(anstream::stderr(), "{label}error:{label:#} {readable}");
        }
    }
    ExitCode::from(BAD_INPUT)
}

/// Prints a message as JSON: the whole, and its parts.
fn complain_as_json(whole: &str, message: &Message, options: &[String]) {
    #[derive(Serialize)]
    struct Complaint<'a> {
        message: &'a str,
        #[serde(flatten)]
        parts: &'a Message,
        #[serde(skip_serializing_if = "<[String]>::is_empty")]
        options: &'a [String],
    }
    let error = Complaint { message: whole, parts: message, options };
    let text = format!("{:#}", json!({"error": error}));
    let _ = writeln!(std::io::stderr(), "{}", text_safety::json(&text));
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
