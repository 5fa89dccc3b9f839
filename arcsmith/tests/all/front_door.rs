//! The program from outside: every command is there with its help, and says as much as it is asked to.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn arcsmith(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arcsmith"))
        .current_dir(folder)
        .env_remove("ARCSMITH_RECORDINGS")
        .env_remove("ARCSMITH_EXAMPLES")
        .args(line.split_whitespace())
        .output()
        .unwrap()
}

fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What there has to be.
const COMMANDS: [&str; 23] = [
    "init",
    "run",
    "status",
    "fit",
    "apply",
    "report",
    "schema",
    "diagnose",
    "fleet",
    "generate",
    "check",
    "verify",
    "explore",
    "budget",
    "record",
    "encode",
    "excite",
    "simulate",
    "effects",
    "trials",
    "completions",
    "man",
    "help",
];
/// Those that show how they are used.
const WITHOUT_EXAMPLES: [&str; 2] = ["schema", "help"];

#[test]
fn every_command_is_listed_and_its_help_shows_examples() {
    let folder = Path::new(".");
    let listing = text(&arcsmith(folder, "--help"));
    for command in COMMANDS {
        assert!(
            listing.lines().any(|line| line.trim_start().starts_with(&format!("{command} "))),
            "{command}"
        );
        if command == "help" {
            continue;
        }
        let help = text(&arcsmith(folder, &format!("{command} --help")));
        for option in ["--json", "--quiet", "--verbose"] {
            assert!(help.contains(option), "{command} {option}");
        }
        if !WITHOUT_EXAMPLES.contains(&command) {
            assert!(help.contains("Examples:\n  arcsmith "), "{command}: {help}");
        }
    }
}

#[test]
fn what_is_generated_is_what_codegen_committed() {
    let folder = tempfile::tempdir().unwrap();
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    let said = text(&arcsmith(folder.path(), "-v generate --demo --out g"));
    assert!(said.contains("proven within"), "{said}");
    for file in
        ["certificate.json", "src/corrected_angle_q31.rs", "c/corrected_angle.c", "c/corrected_angle.h"]
    {
        let read = |folder: &Path| std::fs::read_to_string(folder.join(file)).unwrap();
        assert_eq!(read(&folder.path().join("g")), read(&committed), "{file}");
    }
    let checked = text(&arcsmith(folder.path(), "check --demo --out g"));
    assert!(checked.contains("all up to date"), "{checked}");
    std::fs::write(folder.path().join("g/c/corrected_angle.c"), "").unwrap();
    let stale = arcsmith(folder.path(), "check --demo --out g --json");
    assert_eq!(stale.status.code(), Some(1));
    let value: Value = serde_json::from_slice(&stale.stdout).unwrap();
    assert_eq!(value["stale"][0]["file"], "c/corrected_angle.c");
}

/// A user's path; every step once for people, once as JSON, once in silence.
const PATH: [&str; 12] = [
    "record --protocol calibration --schedule coarse --seed 7 --out c.csv",
    "encode --seed 7 --out e.csv",
    "excite --seed 7 --samples 512 --out m.csv",
    "effects",
    "effects --simulated",
    "fit c.csv --mirror mirror.toml --out c.json",
    "apply c.csv --coefficients c.json --out angles.csv",
    "report c.csv --mirror mirror.toml --out report.html --overview o.svg",
    "generate --coefficients c.json --out g --format q31",
    "check --coefficients c.json --out g --format q31",
    "budget --coefficients c.json --format q31 --out b.html",
    "explore --coefficients c.json --target cortex-m4f --format q15",
];

#[test]
fn every_step_says_as_much_as_it_is_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    text(&arcsmith(folder.path(), "init --out mirror.toml --quiet"));
    for step in PATH {
        let people = text(&arcsmith(folder.path(), step));
        assert!(!people.trim().is_empty(), "{step}");
        // Nobody looks at a terminal here.
        assert!(!people.contains('\u{1b}'), "{step}: {people:?}");
        let json = text(&arcsmith(folder.path(), &format!("--json {step}")));
        assert!(serde_json::from_str::<Value>(&json).is_ok(), "{step}: {json}");
        assert_eq!(text(&arcsmith(folder.path(), &format!("{step} -q"))), "", "{step}");
        let both = arcsmith(folder.path(), &format!("{step} -q -v"));
        assert_eq!(both.status.code(), Some(2), "{step}");
    }
    assert!(folder.path().join("o-dark.svg").is_file());
    let wrong = arcsmith(folder.path(), "fit nothing.csv --mirror mirror.toml");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8(wrong.stderr).unwrap().contains("nothing.csv"));
    let error = |line: &str| -> Value {
        let wrong = arcsmith(folder.path(), line);
        assert_eq!((wrong.status.code(), wrong.stdout), (Some(2), Vec::new()), "{line}");
        serde_json::from_slice::<Value>(&wrong.stderr).unwrap()["error"].take()
    };
    std::fs::write(folder.path().join("bad.csv"), BAD_CELL).unwrap();
    let told = error("fit bad.csv --mirror mirror.toml --json");
    for (part, value) in [("file", "bad.csv"), ("column", "x1_mm"), ("found", "oops")] {
        assert_eq!(told[part], value, "{told}");
    }
    assert_eq!(told["line"], 3, "{told}");
    assert!(
        told["expected"].is_string() && told["mend"].is_string() && told["message"].is_string(),
        "{told}"
    );
    assert!(error("fit --json")["message"].is_string());
}

const BAD_CELL: &str = "\
t_s,pass,direction,x1_mm,x2_mm,reference_arcsec
0,1,1,0.1,-0.1,100
1,1,1,oops,-0.1,100
";

#[test]
fn a_recording_comes_from_standard_input_too() {
    let folder = tempfile::tempdir().unwrap();
    text(&arcsmith(folder.path(), "init --out mirror.toml --quiet"));
    text(&arcsmith(folder.path(), "record --protocol calibration --schedule coarse --seed 7 --out c.csv.gz"));
    let fit = |recording: &str, out: &str| {
        let input = std::fs::File::open(folder.path().join("c.csv.gz")).unwrap();
        let mut cat = Command::new("cat").stdin(input).stdout(std::process::Stdio::piped()).spawn().unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_arcsmith"))
            .current_dir(folder.path())
            .args(["fit", recording, "--mirror", "mirror.toml", "--out", out])
            .stdin(cat.stdout.take().unwrap())
            .output()
            .unwrap();
        cat.wait().unwrap();
        text(&output);
        let file = std::fs::read_to_string(folder.path().join(out)).unwrap();
        serde_json::from_str::<Value>(&file).unwrap()
    };
    let (named, piped) = (fit("c.csv.gz", "named.json"), fit("-", "piped.json"));
    assert_eq!(named["base"], piped["base"]);
    assert_eq!(named["recording"]["sha256"], piped["recording"]["sha256"]);
}

#[test]
fn a_diagnosis_is_reported_on_one_screen_or_as_json() {
    let folder = tempfile::tempdir().unwrap();
    text(&arcsmith(folder.path(), "init --out mirror.toml --quiet"));
    let record = "record --protocol calibration --schedule coarse --seed 3 --temperature levels --out warm.csv \
                  --effect thermal_zero_drift:coefficient_arcsec_per_k=1";
    text(&arcsmith(folder.path(), record));
    let diagnose = "diagnose warm.csv --mirror mirror.toml --no-report --out d";
    let said = text(&arcsmith(folder.path(), diagnose));
    assert!(said.starts_with("warm.csv: explained by thermal_zero_drift"), "{said}");
    for label in ["noise ", "where ", "what ", "held out ", "written "] {
        assert!(said.lines().any(|line| line.starts_with(label)), "{label}: {said}");
    }
    assert!(said.lines().count() < 24, "{said}");
    let json = text(&arcsmith(folder.path(), &format!("{diagnose} --json")));
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value[0]["effects"][0]["id"], "thermal_zero_drift");
    let written = std::fs::read_to_string(folder.path().join("d/warm.json")).unwrap();
    assert_eq!(value[0], serde_json::from_str::<Value>(&written).unwrap());
    assert_eq!(text(&arcsmith(folder.path(), &format!("{diagnose} -q"))), "");
}

#[test]
fn trials_run_the_program_itself() {
    let folder = tempfile::tempdir().unwrap();
    // A copy alone in its folder: no other program is beside it.
    let program = folder.path().join(format!("arcsmith{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_arcsmith"), &program).unwrap();
    let output = Command::new(&program)
        .env_remove("ARCSMITH_RECORDINGS")
        .env_remove("ARCSMITH_EXAMPLES")
        .args([
            "trials",
            "static",
            "--trials",
            "2",
            "--nulls",
            "1",
            "--skip-without",
            "--out",
            "out",
            "--json",
        ])
        .current_dir(folder.path())
        .output()
        .unwrap();
    // Figures of so few trials may fail; that is no bad input.
    assert_ne!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    let recordings = value["recordings"].as_u64().unwrap();
    assert!(recordings >= 5, "four nulls and the trials: {recordings}");
    assert_eq!(value["skipped"].as_array().unwrap().len(), 2);
    // Every recording was answered, with the diagnosis and its coefficients.
    let answers = std::fs::read_dir(folder.path().join("out/diagnosed")).unwrap().count();
    assert_eq!(answers as u64, 2 * recordings);
}

#[test]
fn shells_and_man_get_every_command() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = text(&arcsmith(folder.path(), &format!("completions {shell}")));
        for command in ["diagnose", "generate", "simulate"] {
            assert!(script.contains(command), "{shell} {command}");
        }
    }
    let script = folder.path().join("arcsmith.bash");
    std::fs::write(&script, text(&arcsmith(folder.path(), "completions bash"))).unwrap();
    let complete = format!(
        ". {} && COMP_WORDS=(arcsmith gen) COMP_CWORD=1 && _arcsmith arcsmith gen arcsmith && echo ${{COMPREPLY[@]}}",
        script.display()
    );
    let completed = Command::new("bash").args(["-c", &complete]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&completed.stdout).trim(), "generate", "{completed:?}");

    text(&arcsmith(folder.path(), "man --out . --quiet"));
    for page in
        ["arcsmith", "arcsmith-fit", "arcsmith-generate", "arcsmith-diagnose", "arcsmith-trials-static"]
    {
        let page = std::fs::read_to_string(folder.path().join(format!("{page}.1"))).unwrap();
        assert!(page.starts_with(".ie") && page.contains(".SH SYNOPSIS"), "{page}");
    }
    let page = text(&arcsmith(folder.path(), "man"));
    assert!(page.contains("arcsmith\\-generate(1)") && page.contains(".SH NAME"), "{page}");
}
