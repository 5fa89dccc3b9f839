//! `twin`: everything is in [`twin::cli`].

fn main() -> std::process::ExitCode {
    twin::cli::main()
}
