//! `fitter`: everything is in [`fitter::cli`].

fn main() -> std::process::ExitCode {
    fitter::cli::main()
}
