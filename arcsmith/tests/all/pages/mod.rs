//! One page of each kind as a browser draws it, the commands that it proposes, and its size.

pub mod browser;

use std::path::Path;
use std::process::Command;

/// What a page may weigh, whatever the recording.
const MOST_BYTES: u64 = 2_000_000;

fn arcsmith(folder: &Path, command: &str) {
    let words: Vec<&str> = command.split_whitespace().collect();
    let mut program = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
    // Trials score real recordings as well where these name them.
    program.env_remove("ARCSMITH_RECORDINGS").env_remove("ARCSMITH_EXAMPLES");
    let output = program.current_dir(folder).args(&words).output().unwrap();
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A folder with a page of each kind: a calibration with its verification, an encoder, a diagnosis that names the effect,
/// one that describes it, one of an encoder, one of a mechanism in motion, an uncertainty budget, what changed between two
/// recordings of a mirror and of a mechanism, a fleet, and blind trials.
fn pages() -> (tempfile::TempDir, [&'static str; 11]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("units")).unwrap();
    let plant = "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n";
    std::fs::write(folder.path().join("plant.toml"), plant).unwrap();
    for command in [
        "init --out mirror.toml",
        "init --kind encoder --out encoder.toml",
        "record --protocol calibration --seed 7 --out calibration.csv",
        "record --protocol verification --device-seed 7 --seed 8 --out verification.csv",
        "report calibration.csv verification.csv --mirror mirror.toml --out report.html",
        "encode --seed 7 --out encoder.csv",
        "report encoder.csv --mirror encoder.toml --out encoder.html --no-svg",
        "record --protocol calibration --seed 7 --temperature levels \
         --effect thermal_zero_drift:coefficient_arcsec_per_k=0.5 --out warm.csv",
        "diagnose warm.csv --mirror mirror.toml --out named",
        "diagnose warm.csv --mirror mirror.toml --without thermal_zero_drift --out described",
        "diagnose encoder.csv --mirror encoder.toml --out turned",
        "excite --seed 7 --effect cubic_stiffness:coefficient=3e-7 --out motion.csv",
        "diagnose motion.csv --plant plant.toml --out moving",
        "budget --recording calibration.csv --mirror mirror.toml --out budget.html",
        "record --protocol calibration --device-seed 7 --seed 9 --temperature levels \
         --effect thermal_zero_drift:coefficient_arcsec_per_k=2.5 --out units/later.csv",
        "record --protocol calibration --seed 5 --out units/other.csv",
        "compare warm.csv units/later.csv --mirror mirror.toml --out compared",
        "excite --seed 8 --device-seed 7 --out later_motion.csv",
        "compare motion.csv later_motion.csv --plant plant.toml --out moved",
        "fleet units --mirror mirror.toml --out units_found",
        "trials static --trials 1 --nulls 1 --skip-without --seed 7 --out trials",
    ] {
        arcsmith(folder.path(), command);
    }
    let names = [
        "report.html",
        "encoder.html",
        "named/warm.html",
        "described/warm.html",
        "turned/encoder.html",
        "moving/motion.html",
        "budget.html",
        "compared/compare.html",
        "moved/compare.html",
        "units_found/fleet.html",
        "trials/report.html",
    ];
    (folder, names)
}

#[test]
fn one_page_of_each_kind_is_drawn_well_and_proposes_what_runs() {
    let (folder, names) = pages();
    the_page_of_a_motion_has_its_equations_and_how_the_residual_is_distributed(folder.path());
    no_text_overlaps_or_leaves_the_page_in_two_widths_both_colour_schemes_and_in_print(folder.path(), &names);
    the_commands_on_a_page_run_in_its_folder_and_its_files_are_there(folder.path(), &names);
}

fn no_text_overlaps_or_leaves_the_page_in_two_widths_both_colour_schemes_and_in_print(
    folder: &Path,
    names: &[&str],
) {
    let Some(browser) = browser::found("the look at one page of each kind") else { return };
    let probe = include_str!("probe.html").replace("PAGES", &serde_json::to_string(names).unwrap());
    std::fs::write(folder.join("probe.html"), probe).unwrap();
    for (scheme, dark) in [("0", true), ("1", false)] {
        let scheme = format!("--blink-settings=preferredColorScheme={scheme}");
        let drawn = browser::measured(&browser, folder, "probe.html", &[&scheme]);
        let drawn = drawn.as_array().unwrap();
        assert_eq!(drawn.len(), 3 * names.len());
        for page in drawn {
            let printed = page["print"] == true;
            let which = format!("{} at {}, dark: {dark}, printed: {printed}", page["name"], page["width"]);
            assert_eq!(page["faults"], serde_json::json!([]), "{which}");
            // What these have is tables, and where there is much to draw a figure.
            let tables =
                ["budget.html", "compared/compare.html", "moved/compare.html", "units_found/fleet.html"];
            let tables = tables.iter().chain(&["trials/report.html"]).any(|name| page["name"] == *name);
            let drawn = page["charts"].as_u64() >= Some(3) && page["hovers"].as_u64() >= Some(35);
            assert!(drawn || tables, "{which}: {page}");
            // Of what was measured several times.
            let several = ["report.html", "encoder.html", "moving/motion.html"];
            let has_bars = several.iter().any(|name| page["name"] == *name);
            assert!(!has_bars || page["bars"].as_u64() >= Some(4), "{which}: {page}");
            // A dark page is darker than a middle grey, a light one and paper are lighter.
            assert_eq!(page["paper"].as_f64().unwrap() < 0.2, dark && !printed, "{which}");
        }
    }
}

fn the_page_of_a_motion_has_its_equations_and_how_the_residual_is_distributed(folder: &Path) {
    let page = std::fs::read_to_string(folder.join("moving/motion.html")).unwrap();
    let formula = page.split("<p>Altogether:</p>\n<pre>").nth(1).and_then(|rest| rest.split("</pre>").next());
    assert_eq!(formula, Some("x″ = gain w − damping v − stiffness x\nx″ −= c x³"));
    for figure in ["spectrum-1", "resonance", "surface", "trace", "histogram", "quantiles"] {
        let drawn = page.split(&format!("<figure id=\"{figure}\">")).nth(1);
        let drawn = drawn.and_then(|rest| rest.split("</figure>").next());
        let drawn = drawn.unwrap_or_else(|| panic!("no figure {figure}"));
        // Columns of a histogram are read off their axis.
        assert!(figure == "histogram" || drawn.contains("<title>"), "{figure} shows no values");
    }
}

fn the_commands_on_a_page_run_in_its_folder_and_its_files_are_there(folder: &Path, names: &[&str]) {
    for name in names {
        let page = std::fs::read_to_string(folder.join(name)).unwrap();
        let commands: Vec<&str> = page.split("<pre>arcsmith ").skip(1).collect();
        let commands: Vec<&str> = commands.iter().filter_map(|rest| rest.split("</pre>").next()).collect();
        // Trials are no step of a user's work.
        if *name == "trials/report.html" {
            continue;
        }
        assert!(!commands.is_empty(), "{name} proposes nothing");
        // Those on the next recording or the next campaign wait for it.
        for command in commands.into_iter().filter(|command| !command.contains("NEXT")) {
            arcsmith(folder, &command.replace("&#x2f;", "/"));
        }
        let files = page.split("<h2>Files written</h2>").nth(1).unwrap().split("</p>").next().unwrap();
        let files: Vec<&str> =
            files.split("<code>").skip(1).filter_map(|rest| rest.split('<').next()).collect();
        assert!(!files.is_empty(), "{name} names no file");
        for file in files {
            assert!(folder.join(file.replace("&#x2f;", "/")).is_file(), "{name}: {file}");
        }
    }
}

#[test]
fn a_page_of_many_readings_is_small_and_says_what_it_draws() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "init --kind encoder --out encoder.toml",
        "encode --seed 7 --readings 1000 --passes 60 --out encoder.csv",
        "report encoder.csv --mirror encoder.toml --out report.html --no-svg",
    ] {
        arcsmith(folder.path(), command);
    }
    let page = folder.path().join("report.html");
    assert!(page.metadata().unwrap().len() <= MOST_BYTES);
    let text = std::fs::read_to_string(page).unwrap();
    assert!(text.contains(" of 72060 readings or means; the others lie under them."));
}
