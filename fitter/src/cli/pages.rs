//! Completions and manual pages, made from a command line's own definition.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use miette::{IntoDiagnostic, Result, miette};
use serde_json::json;

use super::common::print;
use super::{Common, summarise};
use crate::output::FileSet;

/// Arguments of `completions`.
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub struct ManArgs {
    /// Write the pages of all commands into this folder
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints the completions of a program.
pub fn completions(args: &CompletionsArgs, mut program: Command) {
    let name = program.get_name().to_string();
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, name, &mut text);
    print(&String::from_utf8_lossy(&text));
}

/// Prints the manual page of a program, or writes those of all its commands, `program-command.1`.
///
/// # Errors
/// One message; nothing was written.
pub fn man(args: &ManArgs, mut program: Command, common: Common) -> Result<()> {
    program.build();
    let Some(folder) = &args.out else {
        print(&String::from_utf8_lossy(&page(program)?));
        return Ok(());
    };
    if !folder.is_dir() {
        return Err(miette!("{}: is no folder; make it, or give another --out", folder.display()));
    }
    let mut pages = Vec::new();
    collect("", program, &mut pages)?;
    let (mut set, mut written) = (FileSet::new(), Vec::new());
    for (name, text) in pages {
        let path = folder.join(format!("{name}.1"));
        set.put(&path, text).into_diagnostic()?;
        written.push(path.display().to_string());
    }
    set.commit().into_diagnostic()?;
    summarise(common, || json!({"written": written}), || format!("written      {}", written.join(", ")));
    Ok(())
}

fn page(command: Command) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text).into_diagnostic()?;
    Ok(text)
}

/// The page of a command and those of its commands, each under its full name: `man fitter-fit` finds it.
fn collect(above: &str, command: Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let own = command.get_name();
    let name = if above.is_empty() { own.to_string() } else { format!("{above}-{own}") };
    let below: Vec<Command> = command.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    pages.push((name.clone(), page(command)?));
    below.into_iter().try_for_each(|command| collect(&name, command, pages))
}
