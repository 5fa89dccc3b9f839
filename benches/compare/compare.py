#!/usr/bin/env python3
"""Arcsmith beside SciPy, lmfit, a Gaussian process and PySINDy, in one run; writes docs/benchmarks.md."""

import csv
import gzip
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RELEASE = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
ARCSEC = 180 * 3600 / np.pi
MIRROR = """[geometry]
probe_distance_mm = 12.0
initial_gap_mm = 0.3
[reference]
accuracy_arcsec = 1.0
"""
DISTANCE_MM = 12.0
ORDERS = range(1, 16)
SPLITS = 100


def seconds(work, repeats):
    """Median time of `work` and its last result."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def model(coefficients, s):
    """Eq. 6 with a1 standing for a1 - dd/d, in rad; s in mm."""
    return DISTANCE_MM / (s**2 + DISTANCE_MM**2) * np.polynomial.polynomial.polyval(s, coefficients)


def jacobian(order, s):
    return DISTANCE_MM / (s**2 + DISTANCE_MM**2) * np.vander(s, order + 1, increasing=True).T


def scipy_fit(order, s, error):
    """Eq. 11 by the trust-region method that the paper names, with analytic derivatives."""
    from scipy.optimize import least_squares

    rows = jacobian(order, s).T
    found = least_squares(
        lambda a: model(a, s) - error, np.zeros(order + 1), jac=lambda a: rows,
        x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15,
    )
    return found.x


def lmfit_fit(order, s, error):
    import lmfit

    parameters = lmfit.Parameters()
    for power in range(order + 1):
        parameters.add(f"a{power}", value=0.0)
    names = list(parameters)
    found = lmfit.minimize(
        lambda p: model(np.array([p[name].value for name in names]), s) - error, parameters,
        method="leastsq", xtol=1e-15, ftol=1e-15,
    )
    return np.array([found.params[name].value for name in names])


def order_selection(fit, s, error, group, splits):
    """Repeated 70/30 splits over whole angles, orders 1 to 15: Eq. 9 and 10."""
    random = np.random.default_rng(1)
    angles = np.unique(group)
    held_out = round(0.3 * len(angles))
    testing = np.zeros((splits, len(ORDERS)))
    for split in range(splits):
        tested = np.isin(group, random.permutation(angles)[:held_out])
        for column, order in enumerate(ORDERS):
            coefficients = fit(order, s[~tested], error[~tested])
            testing[split, column] = np.sqrt(np.mean((model(coefficients, s[tested]) - error[tested]) ** 2))
    return ORDERS[int(np.argmin(testing.mean(axis=0)))]


def order_table():
    recording = ROOT / "fitter/data/calibration.csv"
    with tempfile.TemporaryDirectory() as folder:
        mirror, out = Path(folder, "mirror.toml"), Path(folder, "coefficients.json")
        mirror.write_text(MIRROR)
        command = [RELEASE / "fitter", "fit", recording, "--mirror", mirror, "--out", out]
        ours, _ = seconds(lambda: subprocess.run(command, check=True, capture_output=True), 20)
        fitted = json.loads(out.read_text())
    with recording.open() as file:
        rows = list(csv.DictReader(file))
    column = lambda name: np.array([float(row[name]) for row in rows])
    s = column("x2_mm") - column("x1_mm")
    alpha0 = fitted["identification"]["zero"]["alpha0_arcsec"]
    error = np.arctan(s / DISTANCE_MM) - (column("reference_arcsec") - alpha0) / ARCSEC
    group = column("command_deg")
    order, coefficients = fitted["base"]["order"], np.array(fitted["base"]["coefficients"])
    grid = np.linspace(s.min(), s.max(), 2001)

    lines = [
        "| | order selection and fit | ratio | largest difference of the fitted curve, rad |",
        "|---|---:|---:|---:|",
        f"| `fitter fit`, the whole program | {1e3 * ours:.1f} ms | 1 | |",
    ]
    # lmfit is timed on fewer splits, and its time scaled: it is the slowest by far.
    for name, fit, splits in [("scipy", scipy_fit, SPLITS), ("lmfit", lmfit_fit, 5)]:
        taken, _ = seconds(lambda: order_selection(fit, s, error, group, splits), 1)
        taken *= SPLITS / splits
        once, theirs = seconds(lambda: fit(order, s, error), 3)
        difference = np.abs(model(theirs, grid) - model(coefficients, grid)).max()
        method = "`least_squares`" if name == "scipy" else "`minimize`"
        scaled = "" if splits == SPLITS else f" (from {splits} splits)"
        lines.append(
            f"| {name} {version(name)} {method} | {taken + once:.1f} s{scaled} "
            f"| {(taken + once) / ours:.0f} | {difference:.1e} |"
        )
    return lines


def read(path):
    with gzip.open(path, "rt") as file:
        header = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",")
    return {name: values[:, index] for index, name in enumerate(header)}


def silverbox_table(folder):
    """Free-run simulation of the Silverbox test recordings from the training file alone."""
    train = folder / "silverbox-train.csv.gz"
    tests = {name: folder / f"silverbox-test-{name}.csv.gz" for name in ("multisine", "arrow")}
    lines = ["| | multisine, mV | arrow, mV | terms | time |", "|---|---:|---:|---|---:|"]
    with tempfile.TemporaryDirectory() as out:
        plant = folder / "silverbox.toml"
        errors, taken, terms = {}, 0.0, ""
        for name, test in tests.items():
            command = [RELEASE / "diagnose", train, "--plant", plant, "--out", out, "--held-out", test, "--no-report"]
            once, _ = seconds(lambda: subprocess.run(command, check=True, capture_output=True), 1)
            taken = max(taken, once)
            simulated = np.loadtxt(Path(out, "silverbox-train.simulated.csv"), delimiter=",", skiprows=1)
            position = read(test)["position"]
            errors[name] = 1e3 * np.sqrt(np.mean((simulated[50:, 2] - position[50:]) ** 2))
            diagnosis = json.loads(Path(out, "silverbox-train.json").read_text())
            terms = ", ".join(effect["id"] for effect in diagnosis["effects"])
        lines.append(
            f"| `diagnose` | {errors['multisine']:.3f} | {errors['arrow']:.3f} | plant + {terms} | {taken:.1f} s |"
        )
    lines.append(pysindy_row(read(train), {name: read(path) for name, path in tests.items()}))
    return lines


def pysindy_row(train, tests):
    """Sparse regression of the acceleration on a cubic library, with smoothed derivatives."""
    import pysindy as ps
    from scipy.signal import savgol_filter

    step = train["t_s"][1] - train["t_s"][0]

    def states(recording):
        smooth = lambda order: savgol_filter(recording["position"], 9, 4, deriv=order, delta=step)
        return np.stack([smooth(0), smooth(1)], axis=1), np.stack([smooth(1), smooth(2)], axis=1)

    start = time.perf_counter()
    x, derivative = states(train)
    scale = np.array([x[:, 0].std(), x[:, 1].std()])
    sindy = ps.SINDy(
        optimizer=ps.STLSQ(threshold=1e-3, alpha=1e-8, normalize_columns=True),
        feature_library=ps.PolynomialLibrary(degree=3),
    )
    sindy.fit(x / scale, t=step, x_dot=derivative / scale, u=train["drive"][:, None])
    taken = time.perf_counter() - start
    terms = int(np.count_nonzero(sindy.coefficients()[1]))
    errors = {}
    for name, test in tests.items():
        begin, _ = states(test)
        t = np.arange(len(test["drive"])) * step
        drive = lambda now: np.interp(now, t, test["drive"])
        right = lambda now, z: sindy.predict(z[None, :], u=np.array([[drive(now)]]))[0]
        z, simulated = begin[0] / scale, [begin[0] / scale]
        for index in range(len(t) - 1):
            k1 = right(t[index], z)
            k2 = right(t[index] + step / 2, z + step / 2 * k1)
            k3 = right(t[index] + step / 2, z + step / 2 * k2)
            k4 = right(t[index] + step, z + step * k3)
            z = z + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not np.all(np.isfinite(z)) or np.abs(z).max() > 1e3:
                break
            simulated.append(z)
        if len(simulated) < len(t):
            errors[name] = "unstable"
        else:
            position = np.array(simulated)[:, 0] * scale[0]
            errors[name] = f"{1e3 * np.sqrt(np.mean((position[50:] - test['position'][50:]) ** 2)):.1f}"
    return (
        f"| PySINDy {version('pysindy')}, degree 3 | {errors['multisine']} | {errors['arrow']} "
        f"| {terms} terms | {taken:.1f} s + simulation |"
    )


def main():
    lines = [
        "# Measured against what one would use otherwise",
        "",
        "Made by `benches/compare/compare.py` in one run; ratios carry over to other machines, times do not. "
        f"Python {platform.python_version()}, numpy {version('numpy')}, {os.cpu_count()} processors.",
        "",
        "## Order selection and fit, 210 rows, orders 1 to 15, 100 splits",
        "",
        *order_table(),
        "",
        "## Missing physics: the Silverbox, trained on its training file, simulated freely on its tests",
        "",
    ]
    folder = os.environ.get("ARCSMITH_RECORDINGS")
    if folder:
        lines += silverbox_table(Path(folder))
    else:
        print("skipped: the Silverbox comparison needs ARCSMITH_RECORDINGS", file=sys.stderr)
        lines += ["Left out in this run: the recordings were not there."]
    (ROOT / "docs/benchmarks.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
