//! `completions`, from the command line's own definition.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::terminal::print;

/// Arguments of `completions`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith completions bash > ~/.local/share/bash-completion/completions/arcsmith
  arcsmith completions zsh > \"${fpath[1]}/_arcsmith\"")]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

pub fn run(args: &CompletionsArgs, mut program: Command) {
    let name = program.get_name().to_string();
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, name, &mut text);
    print(&String::from_utf8_lossy(&text));
}
