//! The commands that a page proposes next, as they are typed.

use std::path::Path;

use fitter::coefficients::Coefficients;
use fitter::figures::inside;
use fitter::text_safety::shell_word;

/// What a command is for, and the command.
pub type Step = (String, String);

fn step(purpose: &str, command: String) -> Step {
    (purpose.to_string(), command)
}

/// A path as a shell takes it.
pub fn quoted_path(path: &Path) -> String {
    shell_word(&path.display().to_string())
}

/// The options that say what a device is, as they are typed: its files by option, mapped columns, effects left out.
pub fn device(files: &[(&str, Option<&Path>)], map: &str, without: &[String]) -> String {
    let files = files.iter().filter_map(|(name, path)| Some(format!(" --{name} {}", quoted_path((*path)?))));
    let without = match without {
        [] => String::new(),
        ids => format!(" --without {}", shell_word(&ids.join(","))),
    };
    files.collect::<String>() + map + &without
}

/// After the figures of a calibration; `model` are the options of its fit.
pub fn after_report(recording: &Path, mirror: &Path, map: &str, model: &str) -> Vec<Step> {
    let (recording, mirror) = (quoted_path(recording), quoted_path(mirror));
    vec![
        step(
            "Write the coefficients",
            format!("arcsmith fit {recording} --mirror {mirror}{map}{model} --out coefficients.json"),
        ),
        step(
            "Generate the correction with its proven bound",
            "arcsmith generate --coefficients coefficients.json --out firmware".to_string(),
        ),
        step(
            "Find out what the model leaves out",
            format!("arcsmith diagnose {recording} --mirror {mirror}{map} --out findings"),
        ),
    ]
}

/// After a budget, of the routine that the command in its head makes.
pub fn after_budget(command: &str) -> Step {
    let options = command.strip_prefix("codegen").unwrap_or_default();
    step(
        "Generate the routine, whose certificate holds the budget",
        format!("arcsmith generate{options} --out firmware"),
    )
}

/// After a calibration was diagnosed: the firmware where there are coefficients, else the next recording.
pub fn after_diagnosis(file: Option<&Coefficients>, coefficients: &Path, again: &str) -> Vec<Step> {
    match file {
        Some(file) => {
            vec![step("Generate the correction with its proven bound", generate(file, coefficients))]
        }
        None => vec![step("Diagnose the next recording", again.to_string())],
    }
}

/// After a mechanism in motion was diagnosed.
pub fn after_motion(plant: &Path, drive: &Path) -> Vec<Step> {
    let (plant, drive) = (quoted_path(plant), quoted_path(drive));
    vec![step(
        "Run the augmented plant on a drive",
        format!("arcsmith simulate --plant {plant} --drive {drive} --out simulated.csv"),
    )]
}

/// After two recordings were compared: what the later one shows by itself, where anything changed.
pub fn after_comparison(now: &Path, device: &str, same: bool) -> Vec<Step> {
    let now = quoted_path(now);
    match same {
        true => vec![step(
            "Compare the next recording with this one",
            format!("arcsmith compare {now} NEXT.csv{device} --out compared"),
        )],
        false => vec![step(
            "Diagnose the later recording by itself, with coefficients for the device as it is now",
            format!("arcsmith diagnose {now}{device} --out findings"),
        )],
    }
}

/// After a fleet: the unit that stands out most, where one does and has a file of its own, and the next campaign.
pub fn after_fleet(outlying: Option<&Path>, device: &str, out: &Path) -> Vec<Step> {
    let unit = outlying.map(|file| {
        let command = format!("arcsmith diagnose {}{device} --out findings", quoted_path(file));
        step("Diagnose the unit that stands out most", command)
    });
    let campaign = step(
        "Compare the next campaign with this one",
        format!("arcsmith fleet NEXT{device} --against {} --out NEXT_results", quoted_path(out)),
    );
    unit.into_iter().chain([campaign]).collect()
}

/// With the inputs that the terms read, in the ranges that were recorded.
fn generate(file: &Coefficients, path: &Path) -> String {
    let read = |name: &str| file.terms.iter().any(|term| term.operator.observables().contains(&name));
    let further: String = (file.observed.iter())
        .filter(|(name, _)| read(name))
        .map(|(name, range)| format!(" --further {}", shell_word(&format!("{name}={}", inside(*range)))))
        .collect();
    format!("arcsmith generate --coefficients {}{further} --out firmware", quoted_path(path))
}
