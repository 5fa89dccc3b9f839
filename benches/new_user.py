#!/usr/bin/env python3
"""A new user's path, timed: from a clone to a firmware file from their own CSV, every step as the tutorial has it.

Everything happens in a temporary folder; crates are fetched as cargo finds them, from its cache where they are there.
With --write the figures take their place in docs/benchmarks.md.
"""

import argparse
import os
import platform
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/benchmarks.md"
BEGIN = "<!-- new_user.py -->"
END = "<!-- /new_user.py -->"


def processor_seconds():
    """Of all processes that have ended under this one."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def step(said, command, folder, environment):
    """Runs a command; what it is, and its seconds of wall and of processors."""
    print(f"$ {' '.join(command)}", flush=True)
    begun, used = time.monotonic(), processor_seconds()
    done = subprocess.run(command, cwd=folder, env=environment)
    if done.returncode != 0:
        sys.exit(f"{said}: {' '.join(command)} ended with {done.returncode}")
    return said, " ".join(command), time.monotonic() - begun, processor_seconds() - used


def seconds(value):
    return f"{value / 60:.1f} min" if value >= 120 else f"{value:.1f} s" if value >= 1 else f"{1000 * value:.0f} ms"


def table(steps, lines):
    text = [
        "## A new user's path, from a clone to a firmware file",
        "",
        f"Made by `benches/new_user.py` on a clean clone, nothing built before, crates in cargo's cache; "
        f"{os.cpu_count()} processors, {platform.machine()}. The recording is the user's own: a CSV of {lines} rows "
        "that lies there already.",
        "",
        "| step | command | wall | processors |",
        "|---|---|---:|---:|",
    ]
    text += [f"| {said} | `{command}` | {seconds(wall)} | {seconds(used)} |" for said, command, wall, used in steps]
    after = steps[2:]
    text += [
        f"| all | | {seconds(sum(s[2] for s in steps))} | {seconds(sum(s[3] for s in steps))} |",
        f"| once it is installed | | {seconds(sum(s[2] for s in after))} | {seconds(sum(s[3] for s in after))} |",
    ]
    return "\n".join(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--from", dest="source", default=str(ROOT), help="what is cloned [this checkout]")
    parser.add_argument("--csv", type=Path, help="a calibration recording [one is simulated, and not timed]")
    parser.add_argument("--note", default="", help="what else is to be known of this run, a sentence under the table")
    parser.add_argument("--write", action="store_true", help="put the figures into docs/benchmarks.md")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        environment = {k: v for k, v in os.environ.items() if k not in ("CARGO_TARGET_DIR", "CARGO_INCREMENTAL")}
        environment["PATH"] = f"{scratch / 'installed/bin'}:{environment['PATH']}"
        clone = scratch / "arcsmith"
        install = ["cargo", "install", "--quiet", "--locked", "--path", "arcsmith", "--root", str(scratch / "installed")]
        steps = [
            step("clone", ["git", "clone", "--quiet", given.source, "arcsmith"], scratch, environment),
            step("install", install, clone, environment),
        ]
        work = scratch / "work"
        work.mkdir()
        if given.csv:
            shutil.copy(given.csv, work / "calibration.csv")
        else:
            record = ["arcsmith", "record", "--protocol", "calibration", "--seed", "7", "--out", "calibration.csv"]
            subprocess.run(record, cwd=work, env=environment, check=True, stdout=subprocess.DEVNULL)
        options = ["--coefficients", "coefficients.json", "--out", "firmware/angle", "--format", "q31"]
        options += ["--input", "x1x2-counts", "--bits", "16", "--gain", "1.5259e-5", "--output", "nano"]
        for said, command in [
            ("state the mirror", ["arcsmith", "init", "--out", "mirror.toml"]),
            ("fit", ["arcsmith", "fit", "calibration.csv", "--mirror", "mirror.toml", "--out", "coefficients.json"]),
            ("generate", ["arcsmith", "generate", *options]),
            ("check", ["arcsmith", "check", *options]),
            ("compile the C", ["cc", "-std=c99", "-O2", "-c", "firmware/angle/c/corrected_angle.c", "-o", "angle.o"]),
        ]:
            steps.append(step(said, command, work, environment))
        lines = len((work / "calibration.csv").read_text().splitlines()) - 1
        # The path of the clean folder says nothing.
        steps = [(a, b.replace(f" --root {scratch / 'installed'}", "").replace(given.source, "…"), c, d) for a, b, c, d in steps]
        text = table(steps, lines) + (f"\n\n{given.note}" if given.note else "")
    print(text)
    if given.write:
        page = PAGE.read_text()
        before, rest = page.split(BEGIN) if BEGIN in page else (page.rstrip("\n") + "\n\n", END + "\n")
        PAGE.write_text(before + BEGIN + "\n" + text + "\n" + END + rest.split(END, 1)[1])


if __name__ == "__main__":
    main()
