"""Recordings that the program simulates, once for all tests."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(sys.executable).with_name("arcsmith")


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """Runs the program in one folder, and returns what it prints with `--json`; an error where it refuses."""
    folder = tmp_path_factory.mktemp("program")

    def run(*words):
        done = subprocess.run([PROGRAM, *words, "--json"], cwd=folder, capture_output=True, text=True)
        told = done.stdout if done.returncode == 0 else done.stderr
        return json.loads(told) if told.strip() else None

    run.folder = folder
    run("init", "--out", "mirror.toml")
    run("record", "--protocol", "calibration", "--seed", "7", "--out", "calibration.csv")
    drift = "thermal_zero_drift:coefficient_arcsec_per_k=0.2"
    levels = ("--temperature", "levels", "--effect", drift)
    run("record", "--protocol", "calibration", "--seed", "8", *levels, "--out", "warm.csv")
    return run


@pytest.fixture
def folder(run, monkeypatch):
    """The folder of the recordings, which is the current one."""
    monkeypatch.chdir(run.folder)
    return run.folder


@pytest.fixture
def columns(folder):
    """The calibration as a dict of lists."""
    lines = (folder / "calibration.csv").read_text().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    return {name: [row[k] for row in rows] for k, name in enumerate(lines[0].split(","))}
