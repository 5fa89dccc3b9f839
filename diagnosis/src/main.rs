//! `diagnose`: what separates a recording from its simulation.

mod cli;
mod cli_dynamic;

use clap::Parser;

fn main() -> std::process::ExitCode {
    // Messages are one sentence each and stand on one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    match cli::run(&cli::Cli::parse()) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("{report:?}");
            std::process::ExitCode::from(2)
        }
    }
}
