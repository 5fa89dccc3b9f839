//! `fuzz N [SEED]` damages N inputs of the program `arcsmith` and checks what it makes of them;
//! `fuzz --repeat SEED CASE` runs one case again. Exit code 1 where something was wrong.
//!
//! `ARCSMITH_PROGRAMS` names the folder of the program, `target/release` if it is not set. The inputs of a failure
//! are kept in `target/fuzz/<seed>-<case>`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arcsmith_tests::fuzz::case::Case;
use arcsmith_tests::fuzz::kept;
use arcsmith_tests::fuzz::seeds::{Seeds, commands};
use arcsmith_tests::fuzz::summary::Summary;
use arcsmith_tests::programs::root;

const USAGE: &str = "usage: fuzz N [SEED]  or  fuzz --repeat SEED CASE";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match fuzz(&words.iter().map(String::as_str).collect::<Vec<_>>()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failures) => {
            eprintln!("{failures} failures");
            ExitCode::FAILURE
        }
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

/// Runs what is asked for, and gives the number of failures.
fn fuzz(words: &[&str]) -> Result<usize, String> {
    let number = |word: &str| word.parse::<u64>().map_err(|_| format!("`{word}` is no number; {USAGE}"));
    let (cases, seed, committed) = match *words {
        ["--repeat", seed, case] => (number(case)?..number(case)? + 1, number(seed)?, false),
        [count] => (0..number(count)?, 1, true),
        [count, seed] => (0..number(count)?, number(seed)?, true),
        _ => return Err(USAGE.into()),
    };
    let folder = std::env::var_os("ARCSMITH_PROGRAMS");
    let program = folder.map_or_else(|| root().join("target/release"), PathBuf::from).join("arcsmith");
    let program =
        program.canonicalize().map_err(|error| format!("{}: {error}; build it", program.display()))?;
    let seeds = Seeds::make(&program)?;
    let mut summary = Summary::default();
    if committed {
        undamaged(&seeds, &program)?;
        for (what, case) in kept::cases(&seeds)? {
            let (outcome, wrong) = case.run(&program)?;
            wrong.iter().for_each(|found| eprintln!("committed case `{what}`: {found}"));
            summary.add("committed", &outcome, !wrong.is_empty());
        }
    }
    let count = cases.end;
    for number in cases {
        let case = Case::draw(&seeds, seed, number);
        let (outcome, wrong) = case.run(&program)?;
        if !wrong.is_empty() {
            kept::keep(&case, &program, &root().join(format!("target/fuzz/{seed}-{number}")))?;
            eprintln!("seed {seed}, case {number}: arcsmith {:.1000}", kept::quoted(&case.arguments));
            wrong.iter().for_each(|what| eprintln!("    {what}"));
        }
        summary.add(seeds.options.command(&case.arguments), &outcome, !wrong.is_empty());
        if (number + 1) % 500 == 0 {
            eprintln!("{} of {count} cases, {} failures", number + 1, summary.failures());
        }
    }
    print!("{summary}");
    Ok(summary.failures())
}

/// Every command on undamaged files must do its work: else the fuzzer tries nothing with it.
fn undamaged(seeds: &Seeds, program: &Path) -> Result<(), String> {
    for line in commands() {
        let (outcome, wrong) = Case::of(seeds, line).run(program)?;
        if outcome.code != Some(0) || !wrong.is_empty() {
            let said = String::from_utf8_lossy(&outcome.stderr).into_owned();
            return Err(format!("undamaged: arcsmith {}: {said}{}", line.words, wrong.join("\n")));
        }
    }
    Ok(())
}
