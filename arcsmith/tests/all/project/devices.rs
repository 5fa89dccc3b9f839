//! A target that serves several devices: each is fitted and gets its page of coefficients.

use super::Folder;

/// A project with three devices beside the recording that is diagnosed.
fn with_devices() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("units")).unwrap();
    for seed in 1..=3 {
        folder.ok(&format!("record --protocol calibration --seed {seed} --out units/unit{seed}.csv --quiet"));
    }
    let target = "out = \"firmware/angle\"\ndevices = \"units/*.csv\"\npage_address = \"0x0801f800\"";
    folder.edit("out = \"firmware/angle\"", target);
    folder
}

#[test]
fn every_device_is_fitted_and_gets_its_page() {
    let folder = with_devices();
    let said = folder.ok("run");
    assert!(said.contains("3 units, each proven within"), "{said}");
    for unit in ["unit1", "unit2", "unit3"] {
        assert!(folder.path().join(format!("results/devices/{unit}.json")).is_file(), "{unit}");
        assert!(folder.path().join(format!("firmware/angle/pages/{unit}.bin")).is_file(), "{unit}");
        let page = folder.read(&format!("firmware/angle/pages/{unit}.hex"));
        // The upper half of the address stands in the first record, the lower one in the second.
        assert!(page.starts_with(":020000040801F1\n:10F800"), "{page}");
    }
    folder.ok("check");
}

#[test]
fn a_device_that_changes_or_comes_makes_its_fit_and_the_target_stale_and_nothing_else() {
    let folder = with_devices();
    folder.ok("run --quiet");
    let shorter = folder.read("units/unit2.csv").lines().take(200).collect::<Vec<_>>().join("\n") + "\n";
    folder.write("units/unit2.csv", shorter);
    assert!(folder.state("fit").contains("units/unit2.csv: stale: units/unit2.csv changed"));
    assert_eq!(folder.state("fit").matches("up to date").count(), 3);
    assert!(folder.state("generate").contains("stale: waits for fit units/unit2.csv"));
    assert!(folder.refused("generate").contains("units/unit2.csv: changed since `fit units/unit2.csv`"));
    folder.ok("run --quiet");
    folder.ok("record --protocol calibration --seed 4 --out units/unit4.csv --quiet");
    assert!(folder.state("fit").contains("units/unit4.csv: not done yet"));
    folder.ok("run --quiet");
    assert!(folder.path().join("firmware/angle/pages/unit4.bin").is_file());
    folder.ok("check");
    // A page by hand.
    folder.write("firmware/angle/pages/unit1.bin", "");
    assert_eq!(folder.run("check").status.code(), Some(1));
}

#[test]
fn devices_that_are_not_there_or_are_one_are_refused() {
    let folder = with_devices();
    folder.write("unit1.csv", folder.read("units/unit1.csv"));
    let files = folder.files();
    for (devices, parts) in [
        ("\"none/*.csv\"", ["`generate.devices`: no file matches none/*.csv", "correct the path"]),
        ("[\"unit1.csv\", \"units/unit1.csv\"]", ["would be one device", "rename one of the two"]),
        ("[\"unit9.csv\"]", ["unit9.csv: there is no such file", "name another in arcsmith.toml"]),
        ("[1]", ["`generate.devices`, found 1", "expected a text in quotes"]),
    ] {
        let text = folder.read("arcsmith.toml");
        folder.edit("devices = \"units/*.csv\"", &format!("devices = {devices}"));
        let said = folder.refused("run");
        parts.iter().for_each(|part| assert!(said.contains(part), "{devices}, {part}: {said}"));
        folder.write("arcsmith.toml", text);
    }
    folder.edit("devices = \"units/*.csv\"\n", "");
    let said = folder.refused("run");
    assert!(said.contains("`generate.page_address` belongs to a target with `devices`"), "{said}");
    folder.edit("page_address", "devices = \"units/*.csv\"\npage_address");
    assert!(folder.files() == files);
}
