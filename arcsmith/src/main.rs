//! The program `arcsmith`, which is [`arcsmith::run`].

fn main() -> std::process::ExitCode {
    arcsmith::run(std::env::args_os().collect())
}
