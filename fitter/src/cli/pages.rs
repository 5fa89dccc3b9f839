//! Completions and manual pages, made from the command line's own definition.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use miette::{IntoDiagnostic, Result, miette};
use serde_json::json;

use super::{Cli, Common, summarise};
use crate::output;

/// Arguments of `fitter completions`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  fitter completions bash > ~/.local/share/bash-completion/completions/fitter
  fitter completions zsh > \"${fpath[1]}/_fitter\"")]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Arguments of `fitter man`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  fitter man | man -l -
  fitter man --out ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write the pages of all commands into this folder
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Writes to standard output; that nobody reads it to the end is no error.
fn print(bytes: &[u8]) {
    use std::io::Write;
    let _ = std::io::stdout().write_all(bytes);
}

pub(super) fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "fitter", &mut text);
    print(&text);
    Ok(())
}

pub(super) fn man(args: &ManArgs, common: Common) -> Result<()> {
    let mut root = Cli::command();
    root.build();
    let page = |command: clap::Command| -> std::io::Result<Vec<u8>> {
        let mut text = Vec::new();
        clap_mangen::Man::new(command).render(&mut text)?;
        Ok(text)
    };
    let Some(folder) = &args.out else {
        print(&page(root).into_diagnostic()?);
        return Ok(());
    };
    if !folder.is_dir() {
        return Err(miette!("{}: is no folder; make it, or give another --out", folder.display()));
    }
    let mut written = Vec::new();
    let commands: Vec<clap::Command> =
        root.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    for command in std::iter::once(root).chain(commands) {
        // A subcommand's page is found by `man fitter-fit`.
        let name = match command.get_name() {
            "fitter" => "fitter".to_string(),
            other => format!("fitter-{other}"),
        };
        let path = folder.join(format!("{name}.1"));
        let text = page(command).into_diagnostic()?;
        output::write_whole(&path, |file| file.write_all(&text)).into_diagnostic()?;
        written.push(path.display().to_string());
    }
    summarise(common, || json!({"written": written}), || format!("written      {}", written.join(", ")));
    Ok(())
}
