//! What `init --from` recognises, and what is said of it.

use super::Folder;

/// The simulated recording as a laboratory writes it: other names, other units, a decimal comma, points in time.
fn laboratory(folder: &Folder) {
    folder.ok("record --protocol calibration --seed 7 --out calibration.csv --quiet");
    let mut text = "Timestamp;Run;Dir;Probe 1;Probe 2;Autocollimator (urad);Temp;Shots\n".to_string();
    for (row, line) in folder.read("calibration.csv").lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse::<f64>().unwrap();
        let (seconds, comma) = (number(0), |value: f64| format!("{value:.4}").replace('.', ","));
        let time =
            format!("2026-11-24T{:02}:{:02}:{:06.3}Z", 9, (seconds / 60.0) as u32 % 60, seconds % 60.0);
        let urad = number(6) * 4.848_136_811_095_36;
        text += &format!(
            "{time};{};{};{};{};{};{};{row}\n",
            cells[1],
            cells[2],
            comma(1e3 * number(4)),
            comma(1e3 * number(5)),
            comma(urad),
            comma(number(8)),
        );
    }
    folder.write("lab.csv", text);
}

#[test]
fn columns_are_recognised_and_units_guessed_and_marked() {
    let folder = Folder::empty();
    laboratory(&folder);
    let said = folder.ok("init --from lab.csv");
    assert!(said.contains("taken as seconds since the first row, 2026-11-24T09:00:02.970Z"), "{said}");
    let text = folder.read("arcsmith.toml");
    for line in [
        "t_s = { column = \"Timestamp\" }",
        "pass = { column = \"Run\" }",
        "direction = { column = \"Dir\" }",
        "x1_mm = { column = \"Probe 1\", unit = \"um\" }   # guessed",
        "reference_arcsec = { column = \"Autocollimator (urad)\", unit = \"urad\" }\n",
        "guessed = [\"columns.temperature_c\", \"columns.x1_mm\", \"columns.x2_mm\"]",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    // `run` goes on and says it, `check` fails until it is confirmed.
    let run = folder.run("run");
    assert!(run.status.success(), "{run:?}");
    let (said, warned) = (String::from_utf8(run.stdout).unwrap(), String::from_utf8(run.stderr).unwrap());
    assert!(warned.contains("columns.x1_mm, columns.x2_mm were guessed"), "{warned}");
    assert!(said.contains("column `t_s` holds timestamps: taken as seconds since its first row"), "{said}");
    let check = folder.run("check");
    let told = String::from_utf8(check.stdout).unwrap();
    assert!(
        check.status.code() == Some(1) && told.contains("columns.x1_mm") && told.contains("not confirmed"),
        "{told}"
    );
    let line = text.lines().find(|line| line.starts_with("guessed")).unwrap().to_string();
    folder.edit(&line, "guessed = []");
    folder.ok("check");
}

#[test]
fn the_laboratorys_recording_gives_the_same_fit() {
    let folder = Folder::new();
    folder.ok("fit --quiet");
    let own = folder.json("fit");
    std::fs::remove_file(folder.path().join("arcsmith.toml")).unwrap();
    laboratory(&folder);
    folder.ok("init --from lab.csv --quiet");
    let other = folder.json("fit");
    let rms = |value: &serde_json::Value| value["after"]["rms"].as_f64().unwrap();
    // Four decimals of a micrometre and of a microradian.
    assert!((rms(&own) - rms(&other)).abs() < 1e-3, "{} {}", rms(&own), rms(&other));
}

#[test]
fn whole_numbers_of_an_encoder_are_counts() {
    let folder = Folder::empty();
    folder.ok("encode --seed 7 --out encoder.csv --quiet");
    let mut text = "time_ms,run,enc,ref_deg\n".to_string();
    for line in folder.read("encoder.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let count = (cells[3] / 360.0 * 16384.0).round() as i64 % 16384;
        text += &format!("{},{},{count},{}\n", (1e3 * cells[0]).round(), cells[1], cells[4]);
    }
    folder.write("counts.csv", text);
    folder.ok("init --from counts.csv");
    let text = folder.read("arcsmith.toml");
    for line in [
        "t_s = { column = \"time_ms\", unit = \"ms\" }",
        "measured = { column = \"enc\", unit = \"14bit\" }   # guessed: whole numbers up to 16383",
        "revolution = 360.0",
        "guessed = [\"columns.measured\"]",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    folder.ok("run");
    assert!(folder.path().join("firmware/angle/certificate.json").is_file());
}

#[test]
fn counts_of_milliseconds_since_1970_are_converted_and_that_is_said() {
    let folder = Folder::empty();
    folder.ok("record --protocol calibration --seed 7 --out plain.csv --quiet");
    let mut lines = folder.read("plain.csv").lines().map(str::to_string).collect::<Vec<_>>();
    for line in lines.iter_mut().skip(1) {
        let (time, rest) = line.split_once(',').unwrap();
        *line = format!("{},{rest}", 1_795_521_600_000 + (1e3 * time.parse::<f64>().unwrap()) as i64);
    }
    folder.write("calibration.csv", lines.join("\n"));
    folder.ok("init --from calibration.csv");
    let fit = folder.json("fit");
    assert!(fit["notes"].to_string().contains("1795521602970 ms since 1970"), "{}", fit["notes"]);
    assert!(folder.ok("apply").contains("timestamps"));
    let diagnosed = folder.run("diagnose");
    assert!(String::from_utf8_lossy(&diagnosed.stderr).contains("timestamps"), "{diagnosed:?}");
    assert!(folder.read("results/angles.csv").lines().nth(1).unwrap().starts_with("0,"));
}

#[test]
fn a_project_file_is_never_written_over_and_one_without_a_recording_is_to_be_filled_in() {
    let folder = Folder::empty();
    for kind in ["mirror", "direct", "encoder", "motion"] {
        folder.ok(&format!("init --kind {kind} --force"));
        assert!(folder.refused("init").contains("arcsmith.toml: is there already"));
        let said = folder.ok("");
        assert!(
            said.contains("calibration.csv is missing")
                && said.contains("put calibration.csv into this folder"),
            "{said}"
        );
    }
    folder.write("a.csv", "a,b\n1,2\n3,4\n");
    std::fs::remove_file(folder.path().join("arcsmith.toml")).unwrap();
    let said = folder.refused("init --from a.csv");
    assert!(said.contains("no columns of a sensor are recognised, found `a`, `b`"), "{said}");
    assert!(!folder.path().join("arcsmith.toml").exists());
}

#[test]
fn timestamps_of_a_motion_become_seconds_and_that_is_said() {
    let folder = Folder::empty();
    folder.ok("excite --seed 7 --out motion.csv --quiet");
    let mut text = "t_s,drive,position\n".to_string();
    for line in folder.read("motion.csv").lines().skip(1) {
        let (time, rest) = line.split_once(',').unwrap();
        text += &format!("2026-11-24T12:00:{:09.6}Z,{rest}\n", time.parse::<f64>().unwrap());
    }
    let answer = |recording: &str, text: String| {
        folder.write(recording, text);
        folder.ok(&format!("init --from {recording} --force --quiet"));
        let run = folder.run("run");
        assert!(run.status.success(), "{run:?}");
        let answer = folder.read(&format!("results/diagnosis/{}", recording.replace(".csv", ".json")));
        (answer.replace(recording, "it"), String::from_utf8(run.stderr).unwrap())
    };
    let (seconds, _) = answer("motion.csv", folder.read("motion.csv"));
    let (stamped, said) = answer("stamped.csv", text);
    assert_eq!(stamped, seconds);
    let wanted = "stamped.csv: column `t_s` holds timestamps: taken as seconds since its first row, 2026-11-24T12:00:00.000000Z";
    assert!(said.contains(wanted), "{said}");
    let plant = "results/diagnosis/stamped.plant.toml";
    let simulated = folder.run(&format!("simulate --plant {plant} --drive stamped.csv --out simulated.csv"));
    assert!(String::from_utf8_lossy(&simulated.stderr).contains(wanted), "{simulated:?}");
}
