//! What is typed takes precedence, and nothing of it is lost.

use super::Folder;

/// Two targets, a verification, options of commands.
fn two_targets() -> Folder {
    let folder = Folder::new();
    folder.ok("record --protocol verification --device-seed 7 --seed 8 --out verification.csv --quiet");
    folder.edit("# verifications", "verifications");
    folder.edit("# order = 9", "order = 8");
    folder.edit("# bound_arcsec = 0.01", "bound_arcsec = 0.01");
    folder.edit("# format = \"q31\"", "format = \"q31\"");
    let more = "\n[[generate]]\nout = \"firmware/float\"\nformat = [\"f32\"]\nname = \"angle\"\n";
    folder.write("arcsmith.toml", folder.read("arcsmith.toml") + more);
    folder
}

#[test]
fn every_option_of_the_file_reaches_its_command() {
    let folder = two_targets();
    folder.ok("run");
    let fitted: serde_json::Value = serde_json::from_str(&folder.read("results/coefficients.json")).unwrap();
    assert_eq!(fitted["base"]["coefficients"].as_array().map(Vec::len), Some(9), "{}", fitted["base"]);
    let first = folder.read("firmware/angle/certificate.json");
    assert!(
        first.contains("codegen --coefficients results/coefficients.json --bound-arcsec 0.01 --format q31"),
        "{first}"
    );
    assert!(folder.path().join("firmware/float/src/angle_f32.rs").is_file());
    // The report draws the verification, and it is what is corrected.
    assert!(folder.ok("report").contains("passes"));
    assert!(folder.ok("apply").contains("verification.csv"));
    folder.ok("check");
}

#[test]
fn an_option_that_is_typed_overrides_the_file_and_the_others_stay() {
    let folder = two_targets();
    folder.ok("run --quiet");
    let state = folder.read("results/state.json");
    // Another place, another order: the project's own results stay.
    let fit = folder.json("fit --order 3 --out other.json");
    assert_eq!((&fit["order"], &fit["written"]), (&3.into(), &"other.json".into()));
    folder.ok("check");
    assert_eq!(folder.read("results/state.json"), state);
    // One target by its folder, with another bound.
    let generated = folder.json("generate --out ./firmware/float --bound-arcsec 0.1");
    assert_eq!(generated["out"], "./firmware/float", "{generated}");
    let certificate = folder.read("firmware/float/certificate.json");
    assert!(
        certificate.contains("--bound-arcsec 0.1") && certificate.contains("--format f32"),
        "{certificate}"
    );
    assert!(certificate.contains("angle_f32"), "{certificate}");
    // That is no longer what the project says.
    assert_eq!(folder.run("check").status.code(), Some(1));
    folder.ok("generate --quiet");
    folder.ok("check");
    let both = folder.json("generate");
    assert_eq!(both.as_array().map(Vec::len), Some(2), "{both}");
    assert!(folder.refused("generate --out elsewhere").contains("one of firmware/angle, firmware/float"));
    // Another recording and another source.
    assert!(folder.ok("apply calibration.csv").contains("calibration.csv"));
    folder.ok("generate --demo --out demo --quiet");
    assert!(folder.read("demo/certificate.json").contains("codegen --demo\""));
    // A word that no command knows is refused, in a project as outside.
    assert!(folder.refused("fit --ordre 3").contains("--ordre"));
    assert!(folder.refused("fit --json --ordre 3").contains("--ordre"));
}

#[test]
fn a_column_that_is_typed_overrides_that_column_alone() {
    let folder = Folder::empty();
    folder.ok("record --protocol calibration --seed 7 --out calibration.csv --quiet");
    let lab = folder.read("calibration.csv").replace("x1_mm,x2_mm", "Probe1_mm,Probe2_mm");
    folder.write("lab.csv", lab.replace("temperature_c", "T_um"));
    folder.ok("init --from lab.csv --quiet");
    let fit = folder.json("fit --map temperature_c=T_um");
    let notes = fit["notes"].to_string();
    for mapping in ["x1_mm=Probe1_mm:mm", "x2_mm=Probe2_mm:mm", "temperature_c=T_um"] {
        assert!(notes.contains(mapping), "{mapping}: {notes}");
    }
    // A probe in another unit: its readings are of another size.
    let fit = folder.json("fit --map x1_mm=Probe1_mm:um --out other.json");
    let notes = fit["notes"].to_string();
    assert!(notes.contains("x1_mm=Probe1_mm:um") && notes.contains("x2_mm=Probe2_mm:mm"), "{notes}");
}

#[test]
fn coefficients_of_another_recording_are_not_generated_from_unawares() {
    let folder = Folder::new();
    assert!(folder.refused("generate").contains("`fit` was not run yet"));
    folder.ok("run --quiet");
    folder.ok("record --protocol calibration --seed 8 --out calibration.csv --quiet");
    for command in ["generate", "apply", "verify", "explore", "budget"] {
        let said = folder.refused(command);
        for part in [
            "calibration.csv: changed since `fit`",
            "found SHA-256 ",
            "expected 85fc0f31b885",
            "arcsmith run",
        ] {
            assert!(said.contains(part), "{command}, {part}: {said}");
        }
    }
    // Who names them takes them as they are.
    folder.ok("generate --coefficients results/coefficients.json --quiet");
}

#[test]
fn firmware_of_a_diagnosis_holds_what_it_named() {
    let folder = Folder::empty();
    folder.ok("record --protocol calibration --seed 3 --temperature levels --out warm.csv --quiet \
         --effect thermal_zero_drift:coefficient_arcsec_per_k=1");
    folder.ok("init --from warm.csv --quiet");
    let run = folder.run("run");
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.success() && said.contains("set coefficients = \"diagnosis\""), "{said}");
    folder.edit("coefficients = \"fit\"", "coefficients = \"diagnosis\"");
    folder.edit("# format = \"q31\"", "further = [\"temperature_c=15..35\"]");
    folder.ok("run");
    let header = folder.read("firmware/angle/c/corrected_angle.h");
    assert!(header.contains("temperature_c"), "{header}");
    folder.ok("check");
}

#[test]
fn a_mechanism_in_motion_is_diagnosed() {
    let folder = Folder::empty();
    folder.ok("excite --seed 7 --samples 1024 --out motion.csv --quiet");
    folder.ok("init --from motion.csv --quiet");
    let text = folder.read("arcsmith.toml");
    assert!(text.contains("guessed = [\"plant.position_unit\", \"plant.drive_unit\"]"), "{text}");
    assert!(folder.ok("run").contains("results/diagnosis"));
    assert_eq!(folder.run("check").status.code(), Some(1));
    let line = text.lines().find(|line| line.starts_with("guessed")).unwrap().to_string();
    folder.edit(&line, "");
    folder.ok("check");
    assert!(folder.refused("fit").contains("`fit` needs a sensor"));
}

#[test]
fn the_mirror_and_effects_stand_in_the_file_or_beside_it() {
    const EFFECT: &str = "\n[[effect]]\nid = \"coil_heating\"\ntitle = \"heating by the coil current\"\n\
        adds = \"k * lowpass(coil_a^2, tau)\"\nk = { unit = \"arcsec/A^2\" }\n\
        tau = { unit = \"s\", from = 5, to = 5000 }\nsource = \"test\"\n";
    let (inside, beside) = (Folder::new(), Folder::empty());
    inside.write("arcsmith.toml", inside.read("arcsmith.toml") + EFFECT);
    beside.write("calibration.csv", inside.read("calibration.csv"));
    beside.ok("init --out mirror.toml --quiet");
    beside.write("mine.toml", EFFECT);
    beside.write(
        "arcsmith.toml",
        "mirror = \"mirror.toml\"\neffects = \"mine.toml\"\nrecordings = \"calibration.csv\"\n\
         [generate]\nout = \"firmware/angle\"\n",
    );
    for folder in [&inside, &beside] {
        folder.ok("run --quiet");
        folder.ok("check");
    }
    let routine = "firmware/angle/src/corrected_angle_q31.rs";
    let code = |folder: &Folder| -> Vec<String> {
        let text = folder.read(routine);
        text.lines().filter(|line| !line.starts_with("//")).map(str::to_string).collect()
    };
    assert_eq!(code(&inside), code(&beside));
    // What is wrong in an effect is reported with its file, and what depends on it is stale alone.
    for (folder, file) in [(&inside, "arcsmith.toml"), (&beside, "mine.toml")] {
        folder.write(file, folder.read(file).replace("coil_a^2, tau", "coil_a^2 tau"));
        assert!(folder.state("fit").contains("up to date"));
        assert!(folder.state("diagnose").contains("stale"));
        assert!(folder.refused("run").contains(&format!("{file}, effect `coil_heating`")), "{file}");
    }
}
