//! `trials`: everything is in [`trials::cli`].

fn main() -> std::process::ExitCode {
    trials::cli::main()
}
