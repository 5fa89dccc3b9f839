//! `man`, from the command line's own definition.

use std::path::PathBuf;

use clap::{Args, Command};
use codegen::refused;
use fitter::output::FileSet;
use serde_json::json;

use crate::terminal::{Common, Result, print, summarise};

/// Arguments of `man`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith man | man -l -
  arcsmith man --out ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write the pages of all commands into this folder
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints the manual page of a program, or writes those of all its commands, `program-command.1`.
pub fn run(args: &ManArgs, mut program: Command, common: Common) -> Result<()> {
    program.build();
    let Some(folder) = &args.out else {
        print(&String::from_utf8_lossy(&page(program)?));
        return Ok(());
    };
    if !folder.is_dir() {
        return Err(refused!("is no folder").at(folder).mend("make it, or give another --out"));
    }
    let mut pages = Vec::new();
    collect("", program, &mut pages)?;
    let (mut set, mut written) = (FileSet::new(), Vec::new());
    for (name, text) in pages {
        let path = folder.join(format!("{name}.1"));
        set.put(&path, text)?;
        written.push(path.display().to_string());
    }
    set.commit()?;
    summarise(common, || json!({"written": written}), || format!("written      {}", written.join(", ")));
    Ok(())
}

fn page(command: Command) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text)?;
    Ok(text)
}

/// The page of a command and those of its commands, each under its full name: `man arcsmith-fit` finds it.
fn collect(above: &str, command: Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let own = command.get_name();
    let name = if above.is_empty() { own.to_string() } else { format!("{above}-{own}") };
    let below: Vec<Command> = command.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    pages.push((name.clone(), page(command)?));
    below.into_iter().try_for_each(|command| collect(&name, command, pages))
}
