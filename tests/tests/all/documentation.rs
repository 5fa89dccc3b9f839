//! Every command that the documentation shows is run, and prints what it is shown to print.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use arcsmith_tests::documents::{Block, anchors, blocks, documents, links, printed};
use arcsmith_tests::programs::{both, program, root};

const PROGRAMS: [&str; 2] = ["arcsmith", "codegen"];

/// In place of cargo: `cargo run` starts the program that is built already; all else takes too long here.
const CARGO: &str = r#"#!/bin/sh
if [ "$1" != run ]; then
    echo "the documentation's test cannot run cargo $*: label the block 'sh no-run: why'" >&2
    exit 3
fi
shift
while [ $# -gt 0 ]; do
    case "$1" in
    --release) shift ;;
    -p | --bin) program=$2; shift 2 ;;
    --) shift; break ;;
    *) echo "the documentation's test cannot run cargo run … $1: label the block 'sh no-run: why'" >&2; exit 3 ;;
    esac
done
exec "$program" "$@"
"#;

/// A folder that looks like a fresh clone in which the programs are installed.
fn stage() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).unwrap();
    for name in PROGRAMS {
        std::os::unix::fs::symlink(program(name).get_program(), bin.join(name)).unwrap();
    }
    let cargo = bin.join("cargo");
    fs::write(&cargo, CARGO).unwrap();
    fs::set_permissions(&cargo, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    // The clone is a copy: a command may write anywhere in it.
    copy(&root().canonicalize().unwrap(), &folder.path().join("clone"));
    folder
}

/// Copies what belongs to the project but links and the sources of its programs, which no command here compiles.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (kind, name) = (entry.file_type().unwrap(), entry.file_name());
        let target = to.join(&name);
        let left_out = name == "target" || name == ".git" || (name == "src" && !from.ends_with("generated"));
        if kind.is_dir() && !left_out {
            copy(&entry.path(), &target);
        } else if kind.is_file() {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

fn shell(command: &str, stage: &Path) -> std::process::Output {
    let path = std::env::var("PATH").unwrap_or_default();
    Command::new("sh")
        .args(["-eu", "-c", command])
        .current_dir(stage.join("clone"))
        .env("PATH", format!("{}:{path}", stage.join("bin").display()))
        .env_remove("ARCSMITH_EXAMPLES")
        .output()
        .unwrap()
}

/// The options that a command names and its program does not have.
fn unknown_options(command: &str) -> Vec<String> {
    let mut words: Vec<&str> = command.split_whitespace().collect();
    if words.starts_with(&["cargo", "run"]) {
        let value =
            |flag: &str| words.iter().position(|w| *w == flag).and_then(|at| words.get(at + 1)).copied();
        let name = value("--bin").or(value("-p")).unwrap_or_default();
        let arguments = words.iter().position(|w| *w == "--").map_or(words.len(), |at| at + 1);
        words.splice(..arguments, [name]);
    }
    let Some((name, arguments)) = words.split_first() else { return Vec::new() };
    if !PROGRAMS.contains(name) {
        return Vec::new();
    }
    let mut help = Vec::new();
    for depth in 0..=2.min(arguments.len()) {
        let named = arguments[..depth].iter().take_while(|word| word.starts_with(char::is_alphabetic));
        let output = program(name).args(named).arg("--help").output().unwrap();
        help.push(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let option = |word: &&&str| word.starts_with("--") && word.len() > 2;
    let known = |word: &&str| {
        let long = word.split('=').next().unwrap_or(word);
        help.iter().any(|text| text.split([' ', ',', '\n', '=', '[']).any(|known| known == long))
    };
    arguments.iter().filter(option).filter(|word| !known(word)).map(|word| word.to_string()).collect()
}

/// Runs a block; what went wrong.
fn run(block: &Block, stage: &Path) -> Result<(), String> {
    let unknown: Vec<String> = block.commands().iter().flat_map(|command| unknown_options(command)).collect();
    if !unknown.is_empty() {
        return Err(format!("there is no option {}", unknown.join(", ")));
    }
    match block.not_run() {
        Some("") => return Err("why is it not run? Say `no-run: why`".to_string()),
        Some(_) => return Ok(()),
        None => {}
    }
    if block.text.contains("$ARCSMITH_RECORDINGS") && std::env::var_os("ARCSMITH_RECORDINGS").is_none() {
        println!("  skipped: line {}: ARCSMITH_RECORDINGS names no folder", block.line);
        return Ok(());
    }
    for step in block.steps() {
        let output = shell(&step.command, stage);
        if !output.status.success() {
            return Err(format!("{}: {}\n{}", step.command, output.status, both(&output)));
        }
        if let Err(line) = printed(&step.shown, &both(&output)) {
            return Err(format!("{}: does not print\n  {line}\nbut\n{}", step.command, both(&output)));
        }
    }
    Ok(())
}

#[test]
fn every_command_in_the_documentation_runs_and_prints_what_is_shown() {
    let mut wrong = BTreeMap::new();
    let mut ran = 0;
    for document in documents(&root()) {
        let name = document.strip_prefix(root()).unwrap().display().to_string();
        let found = blocks(&fs::read_to_string(&document).unwrap());
        // A command in a block without a label would never be run.
        for block in found.iter().filter(|block| block.label.is_empty() || block.label == "bash") {
            let command = |line: &str| {
                let first = line.trim_start_matches("$ ").split_whitespace().next().unwrap_or_default();
                first == "cargo" || PROGRAMS.contains(&first)
            };
            if block.text.lines().any(command) {
                wrong
                    .insert((name.clone(), block.line), "shows commands: label it sh or console".to_string());
            }
        }
        let commands: Vec<&Block> = found.iter().filter(|block| block.is_run()).collect();
        if commands.is_empty() {
            continue;
        }
        println!("{name}");
        let stage = stage();
        for block in commands {
            let begun = std::time::Instant::now();
            if let Err(what) = run(block, stage.path()) {
                wrong.insert((name.clone(), block.line), what);
            }
            println!("  line {}: {:.1} s", block.line, begun.elapsed().as_secs_f64());
            ran += 1;
        }
    }
    let told: Vec<String> =
        wrong.iter().map(|((name, line), what)| format!("{name}, line {line}: {what}")).collect();
    assert!(told.is_empty(), "{}", told.join("\n\n"));
    assert!(ran > 5, "the documentation shows commands");
}

#[test]
fn every_link_leads_to_a_file_and_a_heading_that_are_there() {
    let mut wrong = Vec::new();
    for document in documents(&root()) {
        for (line, link) in links(&fs::read_to_string(&document).unwrap()) {
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let page = if path.is_empty() { document.clone() } else { document.parent().unwrap().join(path) };
            let headings = || anchors(&fs::read_to_string(&page).unwrap_or_default());
            let there =
                page.exists() && (anchor.is_empty() || headings().iter().any(|known| known == anchor));
            if !link.contains("://") && !there {
                wrong.push(format!("{}, line {line}: {link}", document.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The pictures are what the program draws.
fn redrawn(commands: &[&str], pictures: &[(&str, &str)]) {
    let folder = tempfile::tempdir().unwrap();
    for command in commands {
        let arguments = command.split(' ');
        let output = program("arcsmith").current_dir(folder.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{command}\n{}", both(&output));
    }
    for (drawn, committed) in pictures {
        let drawn = fs::read_to_string(folder.path().join(drawn)).unwrap();
        let there = fs::read_to_string(root().join("docs/images").join(committed)).unwrap_or_default();
        assert!(drawn == there, "docs/images/{committed} is not what `arcsmith report` draws: draw it again");
    }
}

/// That in the README, of the embedded recording and a verification of the same device.
#[test]
fn the_picture_in_the_readme_is_drawn_by_the_program() {
    let calibration = root().canonicalize().unwrap().join("fitter/data/calibration.csv");
    let report = format!(
        "report {} verification.csv --mirror mirror.toml --overview before-and-after.svg --no-svg",
        calibration.display()
    );
    redrawn(
        &[
            "init --out mirror.toml",
            "record --protocol verification --device-seed 1 --seed 2 --out verification.csv",
            &report,
        ],
        &["before-and-after.svg", "before-and-after-dark.svg"].map(|name| (name, name)),
    );
}

#[test]
fn the_pictures_in_the_tutorial_are_drawn_by_the_program() {
    redrawn(
        &[
            "init --out mirror.toml",
            "record --protocol calibration --seed 7 --out calibration.csv",
            "record --protocol verification --device-seed 7 --seed 8 --out verification.csv",
            "report calibration.csv verification.csv --mirror mirror.toml --out report.html",
        ],
        &[
            ("report-error.svg", "tutorial-error.svg"),
            ("report-order.svg", "tutorial-order.svg"),
            ("report-mean.svg", "tutorial-verification.svg"),
        ],
    );
}
