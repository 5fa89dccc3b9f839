//! `diagnose`: everything is in [`diagnosis::cli`].

fn main() -> std::process::ExitCode {
    diagnosis::cli::main()
}
