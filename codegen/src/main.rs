//! `codegen`: everything is in [`codegen::cli`].

fn main() -> std::process::ExitCode {
    codegen::cli::main()
}
