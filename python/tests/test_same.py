"""What the module computes is what the program computes, to the bit."""

import json
import re
import subprocess
import sys

import arcsmith
import pytest
from conftest import PROGRAM


def test_fit(run, folder):
    told = run("fit", "calibration.csv", "--mirror", "mirror.toml", "--out", "coefficients.json")
    told.pop("written")
    # The program's words have one more: it writes a file.
    fit = arcsmith.fit("calibration.csv", "mirror.toml")
    assert fit.to_dict() == told
    written = json.loads((folder / "coefficients.json").read_text())
    own = fit.coefficients.to_dict()
    for different in ("command", "sha256"):
        written.pop(different), own.pop(different)
    assert own == written
    assert fit.order == 9 and fit.unit == "arcsec" and fit.after_rms < 0.6 < fit.before_rms


def test_fit_of_a_file_is_the_programs_file(run, folder):
    run("fit", "calibration.csv", "--mirror", "mirror.toml", "--order", "9")
    assert arcsmith.fit("calibration.csv", "mirror.toml", order=9).coefficients.to_json() != ""
    program = json.loads((folder / "coefficients.json").read_text())["command"]
    own = arcsmith.fit("calibration.csv", "mirror.toml", order=9).coefficients.to_dict()["command"]
    assert own == "arcsmith fit calibration.csv --mirror mirror.toml --order 9"
    assert program == own + " --json"


def found_on(page):
    """What a page shows beside the program's files and next commands."""
    next_command = r"<p>[^<]*:</p>\s*<pre>arcsmith [^<]*</pre>"
    files = r"<h2>Files written</h2>\s*<p>.*?</p>"
    heading = r"<h2>What to do next</h2>"
    return re.sub(r"\s+", " ", re.sub(f"{next_command}|{files}|{heading}", "", page, flags=re.S))


@pytest.mark.parametrize("recording", ["calibration.csv", "warm.csv"])
def test_diagnosis(run, folder, recording):
    run("diagnose", recording, "--mirror", "mirror.toml", "--out", "diagnosis")
    diagnosis = arcsmith.diagnose(recording, "mirror.toml")
    stem = recording.removesuffix(".csv")
    assert diagnosis.to_json() == (folder / f"diagnosis/{stem}.json").read_text()
    assert found_on(diagnosis.report()) == found_on((folder / f"diagnosis/{stem}.html").read_text())
    assert diagnosis.coefficients.to_json() == (folder / f"diagnosis/{stem}.coefficients.json").read_text()


def test_diagnosis_of_a_table_under_the_files_name(run, folder, columns):
    run("diagnose", "calibration.csv", "--mirror", "mirror.toml", "--out", "diagnosis")
    diagnosis = arcsmith.diagnose(columns, "mirror.toml", name="calibration.csv")
    assert diagnosis.to_json() == (folder / "diagnosis/calibration.json").read_text()
    assert found_on(diagnosis.report()) == found_on((folder / "diagnosis/calibration.html").read_text())


def test_what_was_found(folder):
    diagnosis = arcsmith.diagnose("warm.csv", "mirror.toml")
    assert diagnosis.verdict == "explained" and diagnosis.effects == ["thermal_zero_drift"]


def test_applied(run, folder):
    run("fit", "calibration.csv", "--mirror", "mirror.toml", "--out", "coefficients.json")
    told = run("apply", "warm.csv", "--coefficients", "coefficients.json", "--out", "angles.csv")
    told.pop("written")
    applied = arcsmith.apply("warm.csv", "coefficients.json")
    assert applied.summary == told
    lines = (folder / "angles.csv").read_text().splitlines()
    assert lines[0] == ",".join(applied.columns)
    rows = zip(*applied.to_dict().values())
    assert [f"{t:g},{angle:.6f},{out:g}" for t, angle, out in rows] == [
        f"{float(t):g},{angle},{out}" for t, angle, out in (line.split(",") for line in lines[1:])
    ]


def test_generated(run, folder):
    run("fit", "calibration.csv", "--mirror", "mirror.toml", "--out", "coefficients.json")
    options = ["--format", "q31", "--input", "x1x2-counts", "--bits", "16", "--gain", "1.5259e-5", "--output", "nano"]
    told = run("generate", "--coefficients", "coefficients.json", *options, "--out", "firmware")
    generated = arcsmith.generate(
        "coefficients.json", format="q31", input="x1x2-counts", bits=16, gain=1.5259e-5, output="nano"
    )
    assert generated.to_dict() == {key: told[key] for key in ("reservation", "routines", "files")}
    for path, text in generated.files.items():
        assert text == (folder / "firmware" / path).read_text(), path
    assert generated.write(folder / "firmware") == 0
    assert generated.write(folder / "other") == len(generated.files)
    assert "proven within" in str(generated)


def test_from_fit_to_firmware_without_a_file(folder):
    fit = arcsmith.fit("calibration.csv", "mirror.toml")
    of_fit = arcsmith.generate(fit, format="q31").files
    assert of_fit == arcsmith.generate(fit.coefficients, format=["q31"]).files
    assert of_fit == arcsmith.generate(fit.coefficients.to_dict(), format="q31").files
    fused = arcsmith.generate(fit, format="f32", fma=True).files
    assert "fused(y, x, " in fused["c/corrected_angle.c"]
    assert len(arcsmith.apply("calibration.csv", arcsmith.diagnose("calibration.csv", "mirror.toml"))) == 210


PLANT = {"plant": {"kind": "second-order", "position_unit": "arcsec", "drive_unit": "A"}}
PLANT_FILE = '[plant]\nkind = "second-order"\nposition_unit = "arcsec"\ndrive_unit = "A"\n'


def test_motion(run, folder):
    run("excite", "--seed", "7", "--samples", "4096", "--out", "motion.csv")
    (folder / "plant.toml").write_text(PLANT_FILE)
    run("diagnose", "motion.csv", "--plant", "plant.toml", "--out", "motion")
    diagnosis = arcsmith.diagnose("motion.csv", plant=PLANT)
    assert diagnosis.to_json() == (folder / "motion/motion.json").read_text()
    assert diagnosis.plant == (folder / "motion/motion.plant.toml").read_text()
    assert diagnosis.coefficients is None and diagnosis.plot()
    diagnosis.simulated.write("simulated.csv")
    assert (folder / "simulated.csv").read_text() == (folder / "motion/motion.simulated.csv").read_text()
    run("simulate", "--plant", "motion/motion.plant.toml", "--drive", "motion.csv", "--out", "again.csv")
    arcsmith.simulate("motion.csv", "motion/motion.plant.toml").write("own.csv")
    assert (folder / "own.csv").read_text() == (folder / "again.csv").read_text()


def test_the_program_is_there(run, folder):
    words = [PROGRAM, "diagnose", "calibration.csv", "--mirror", "mirror.toml", "--out", "d"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("calibration.csv: consistent with the simulation")
    refused = subprocess.run([sys.executable, "-m", "arcsmith", "fit", "nowhere.csv"], capture_output=True, text=True)
    assert refused.returncode == 2 and refused.stderr.startswith("error: the following required arguments")
    plan = ["--trials", "1", "--nulls", "1", "--skip-without", "--seed", "1", "--out", "trials"]
    done = subprocess.run([PROGRAM, "trials", "static", *plan], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
