//! `budget`: tables, JSON and a page that say the same as the certificate, and what is missing first of all.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn arcsmith(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_arcsmith"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn text(folder: &Path, line: &str) -> String {
    let output = arcsmith(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn text_json_and_page_say_what_the_certificate_says() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    text(folder, "record --protocol calibration --seed 7 --out c.csv -q");
    text(folder, "init --out mirror.toml -q");
    text(folder, "fit c.csv --mirror mirror.toml --out c.json -q");
    text(folder, "generate --coefficients c.json --format q31 --out g -q");
    let line = "budget --coefficients c.json --format q31";
    let json: Value = serde_json::from_str(&text(folder, &format!("{line} --out b.html --json"))).unwrap();
    let certificate: Value = serde_json::from_str(&read(folder, "g/certificate.json")).unwrap();
    assert_eq!(json["budgets"], certificate["budgets"]);
    let budget = &json["budgets"][0]["budget"];
    let people = text(folder, line);
    let page = read(folder, "b.html");
    let components = budget["components"].as_array().unwrap();
    assert!(components.len() >= 5, "{components:?}");
    for component in components {
        let what = component["what"].as_str().unwrap();
        assert!(people.contains(what) && page.contains(what), "{what}: {people}");
    }
    let measurand = budget["measurand"].as_str().unwrap();
    let on_page = page.contains(&measurand.replace('\'', "&#x27;"));
    assert!(people.contains(measurand) && on_page, "{measurand}");
    assert!(page.contains("JCGM 100") && page.contains(json["coefficients_sha256"].as_str().unwrap()));
    assert!(!people.contains("missing"), "{people}");
    // The page of the calibration has it too.
    text(folder, "report c.csv --mirror mirror.toml --no-svg -q");
    assert!(read(folder, "report.html").contains("Uncertainty budget (JCGM 100)"));
}

#[test]
fn a_reference_without_accuracy_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    text(folder, "encode --seed 7 --out e.csv -q");
    text(folder, "init --kind encoder --out e.toml -q");
    text(folder, "fit e.csv --mirror e.toml --out e.json -q");
    let people = text(folder, "budget --coefficients e.json --bits 14 --out b.html");
    let wanted = "the accuracy of the reference: state `accuracy` in deg under [reference] in mirror.toml and fit again";
    assert!(people.contains(wanted), "{people}");
    assert!(read(folder, "b.html").contains("<strong>Missing:</strong> the accuracy of the reference"));
    // As it is said, the file names what is stated.
    let stated = read(folder, "e.toml") + "\n[reference]\naccuracy = 0.01\n";
    std::fs::write(folder.join("e.toml"), stated).unwrap();
    text(folder, "fit e.csv --mirror e.toml --out e.json -q");
    let whole = text(folder, "budget --coefficients e.json --bits 14");
    assert!(whole.contains("reference: stated accuracy") && !whole.contains("missing"), "{whole}");
}

#[test]
fn what_cannot_be_budgeted_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let model = fitter::ErrorModel {
        sensor: fitter::Sensor::Direct { unit: "mm".into(), revolution: None },
        centre: 0.0,
        coefficients: vec![0.1, 0.01],
    };
    let by_hand = fitter::Coefficients::of_model(&model, -1.0, 1.0, "by hand");
    std::fs::write(folder.join("c.json"), by_hand.to_sealed_json()).unwrap();
    for (line, said) in [
        ("budget --coefficients c.json --out b.html", "do not say what a recording showed of the noise"),
        ("budget --demo --devices c.json", "--devices"),
        ("budget --coefficients c.json --out c.json", "c.json"),
        ("budget --coefficients nothing.json", "nothing.json"),
    ] {
        let output = arcsmith(folder, line);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {error}");
        assert!(error.contains(said), "{line}: {error}");
    }
    let left: Vec<_> = std::fs::read_dir(folder).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}
