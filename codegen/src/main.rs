//! `codegen`: see [`codegen::cli`].

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    // One message, one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    match codegen::cli::run(codegen::cli::Cli::parse()) {
        Ok(code) => code,
        Err(report) => {
            eprintln!("{report:?}");
            ExitCode::from(2)
        }
    }
}
