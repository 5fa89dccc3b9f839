//! `trials`: the proof on concealed effects. Exit code 0 where every figure is reached, 1 where one is not,
//! 2 for bad input.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    // Messages are one sentence each and stand on one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    match cli::run(&cli::Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(report) => {
            eprintln!("{report:?}");
            ExitCode::from(2)
        }
    }
}
