#!/usr/bin/env python3
"""Arcsmith beside SciPy, lmfit, a Gaussian process and PySINDy; writes docs/benchmarks.md."""

import csv
import gzip
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
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
# Runs of the order selection, each of every program: processor times differ from run to run.
RUNS = 9


def processor_s():
    """Processor time of this process and of those that it started and waited for: what else runs does not count."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def seconds(work, repeats):
    """Median processor time of `work` and its last result."""
    times = []
    for _ in range(repeats):
        start = processor_s()
        result = work()
        times.append(processor_s() - start)
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
        command = [RELEASE / "arcsmith", "fit", recording, "--mirror", mirror, "--out", out]
        fit_once = lambda: subprocess.run(command, check=True, capture_output=True)
        ours = [seconds(fit_once, 20)[0] for _ in range(RUNS)]
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
        "| | order selection and fit | ratio: median, from … to | largest difference of the fitted curve, rad |",
        "|---|---:|---:|---:|",
        f"| `arcsmith fit`, the whole program | {1e3 * statistics.median(ours):.1f} ms | 1 | |",
    ]
    # lmfit is timed on fewer splits, and its time scaled: it is the slowest by far.
    for name, fit, splits in [("scipy", scipy_fit, SPLITS), ("lmfit", lmfit_fit, 5)]:
        theirs = []
        for _ in range(RUNS):
            taken, _ = seconds(lambda: order_selection(fit, s, error, group, splits), 1)
            once, found = seconds(lambda: fit(order, s, error), 3)
            theirs.append(taken * SPLITS / splits + once)
        ratios = [b / a for a, b in zip(ours, theirs)]
        difference = np.abs(model(found, grid) - model(coefficients, grid)).max()
        method = "`least_squares`" if name == "scipy" else "`minimize`"
        scaled = "" if splits == SPLITS else f" (from {splits} splits)"
        lines.append(
            f"| {name} {version(name)} {method} | {statistics.median(theirs):.1f} s{scaled} "
            f"| {statistics.median(ratios):.0f}, {min(ratios):.0f} … {max(ratios):.0f} | {difference:.1e} |"
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
            command = [RELEASE / "arcsmith", "diagnose", train, "--plant", plant, "--out", out, "--held-out", test, "--no-report"]
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
    """Sparse regression of the acceleration on a cubic library, with smoothed derivatives.

    The threshold is the one whose free run is best on the last fifth of the training file; all of it is trained on
    afterwards. The free run is a Runge-Kutta integration of the equation that was found.
    """
    import pysindy as ps
    from scipy.signal import savgol_filter

    step = train["t_s"][1] - train["t_s"][0]

    def states(recording, rows=slice(None)):
        smooth = lambda order: savgol_filter(recording["position"], 9, 4, deriv=order, delta=step)[rows]
        return np.stack([smooth(0), smooth(1)], axis=1), np.stack([smooth(1), smooth(2)], axis=1)

    scale = states(train)[0].std(axis=0)

    def identified(threshold, rows):
        x, derivative = states(train, rows)
        sindy = ps.SINDy(
            optimizer=ps.STLSQ(threshold=threshold, alpha=1e-8, normalize_columns=True),
            feature_library=ps.PolynomialLibrary(degree=3),
        )
        sindy.fit(x / scale, t=step, x_dot=derivative / scale, u=train["drive"][rows, None])
        return sindy.coefficients()[1], sindy.feature_library.powers_, sindy.get_feature_names()

    def free_run_error(equation, recording, rows=slice(None)):
        """Root mean square in mV of the free run's position, the first 50 rows left out; None where it diverges."""
        coefficients, powers, _ = equation
        kept = [(float(c), [int(p) for p in row]) for c, row in zip(coefficients, powers) if c != 0.0]
        factor = scale[1] / scale[0]

        def right(x, v, u):
            acceleration = sum(c * x ** p[0] * v ** p[1] * u ** p[2] for c, p in kept)
            return v * factor, acceleration

        begin = states(recording, rows)[0][0] / scale
        drive, position = recording["drive"][rows].tolist(), recording["position"][rows]
        x, v = (float(value) for value in begin)
        simulated = [x]
        for now, then in zip(drive, drive[1:]):
            middle = (now + then) / 2
            ax, av = right(x, v, now)
            bx, bv = right(x + step / 2 * ax, v + step / 2 * av, middle)
            cx, cv = right(x + step / 2 * bx, v + step / 2 * bv, middle)
            dx, dv = right(x + step * cx, v + step * cv, then)
            x += step / 6 * (ax + 2 * bx + 2 * cx + dx)
            v += step / 6 * (av + 2 * bv + 2 * cv + dv)
            if not abs(x) < 1e3:
                return None
            simulated.append(x)
        left = np.array(simulated)[50:] * scale[0] - position[50:]
        return 1e3 * float(np.sqrt(np.mean(left**2)))

    start = processor_s()
    fifth = len(train["t_s"]) * 4 // 5
    # The free run for the choice is over 8000 rows: more would only cost time.
    scores = {}
    for threshold in (1e-4, 1e-3, 1e-2, 3e-2, 1e-1, 3e-1):
        error = free_run_error(identified(threshold, slice(0, fifth)), train, slice(fifth, fifth + 8000))
        scores[threshold] = np.inf if error is None else error
    threshold = min(scores, key=scores.get)
    equation = identified(threshold, slice(None))
    taken = processor_s() - start
    names = [name for name, c in zip(equation[2], equation[0]) if c != 0.0]
    readable = [name.replace("x0", "x").replace("x1", "v") for name in names]
    errors = {name: free_run_error(equation, test) for name, test in tests.items()}
    shown = {name: "diverges" if error is None else f"{error:.3f}" for name, error in errors.items()}
    return (
        f"| PySINDy {version('pysindy')}, polynomials to degree 3, threshold {threshold:g} "
        f"| {shown['multisine']} | {shown['arrow']} | {len(names)}: {', '.join(readable)} | {taken:.1f} s |"
    )


EFFECTS = ["thermal_gain_drift:coefficient_ppm_per_k=60", "backlash:half_width_arcsec=2.5"]


def residual_table():
    """A device with two effects in it: diagnosed, and its residual given to a Gaussian process."""
    with tempfile.TemporaryDirectory() as folder:
        path = lambda name: Path(folder, name)
        path("mirror.toml").write_text(MIRROR)

        def run(*command):
            subprocess.run([RELEASE / "arcsmith", *command], check=True, capture_output=True, cwd=folder)

        for name, seed in [("train.csv", "101"), ("test.csv", "102")]:
            concealed = [word for effect in EFFECTS for word in ("--effect", effect)]
            run("record", "--protocol", "calibration", "--schedule", "fine", "--temperature", "levels",
                "--device-seed", "100", "--seed", seed, "--out", name, *concealed)

        def left(recording, coefficients):
            """Corrected less reference in arcsec, the mean taken off: the zero of the reference is unknown."""
            run("apply", recording, "--coefficients", coefficients, "--out", "angles.csv")
            angles = np.loadtxt(path("angles.csv"), delimiter=",", skiprows=1, usecols=1)
            with path(recording).open() as file:
                rows = list(csv.DictReader(file))
            columns = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
            error = angles - columns["reference_arcsec"]
            return error - error.mean(), columns

        run("fit", "train.csv", "--mirror", "mirror.toml", "--out", "base.json")
        before, _ = left("test.csv", "base.json")
        command = ("diagnose", "train.csv", "--mirror", "mirror.toml", "--out", "out", "--no-report")
        ours, _ = seconds(lambda: run(*command), 1)
        diagnosed, _ = left("test.csv", "out/train.coefficients.json")
        found = json.loads(path("out/train.json").read_text())
        names = ", ".join(effect["id"] for effect in found["effects"])

        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

        used = ["reading", "temperature_c", "direction", "cross_arcsec", "coil_a", "t_s"]

        def features(columns):
            table = {**columns, "reading": columns["x2_mm"] - columns["x1_mm"]}
            return np.stack([table[name] for name in used], axis=1)

        error, columns = left("train.csv", "base.json")
        x = features(columns)
        centre, spread = x.mean(axis=0), x.std(axis=0)
        start = processor_s()
        kernel = ConstantKernel(1.0) * RBF(np.ones(len(used)), (1e-1, 1e4)) + WhiteKernel(0.3, (1e-3, 1e2))
        process = GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=2, random_state=1)
        process.fit((x - centre) / spread, error)
        taken = processor_s() - start
        error, columns = left("test.csv", "base.json")
        corrected = error - process.predict((features(columns) - centre) / spread)
        lengths = process.kernel_.k1.k2.length_scale
        depends = ", ".join(name for name, length in sorted(zip(used, lengths), key=lambda p: p[1]) if length < 100)
        rms = lambda values: float(np.sqrt(np.mean((values - values.mean()) ** 2)))
        return [
            "| | rms on a second recording of the device, arcsec | what is named | in the firmware | time |",
            "|---|---:|---|---|---:|",
            f"| polynomial alone | {rms(before):.3f} | | yes | |",
            f"| `diagnose` | {rms(diagnosed):.3f} | {names} | yes | {ours:.1f} s |",
            f"| Gaussian process on the residual, scikit-learn {version('scikit-learn')} | {rms(corrected):.3f} "
            f"| no physics; it depends on {depends} | no: {len(error)} rows of training | {taken:.1f} s |",
            "",
            f"The device is simulated, with {' and '.join(f'`{effect}`' for effect in EFFECTS)} and about 0.5″ of "
            "noise per reading, which no model can remove.",
        ]


def main():
    lines = [
        "# Benchmarks against other fitting tools",
        "",
        "How fast and how well SciPy, lmfit, a Gaussian process and PySINDy do the same tasks. Made by `benches/compare/compare.py`. Times do not carry over to other machines, ratios by their spread over the runs. "
        "Times are of all processors together, start of the program included. "
        f"Python {platform.python_version()}, numpy {version('numpy')}, {os.cpu_count()} processors.",
        "",
        f"## Order selection and fit, 210 rows, orders 1 to 15, 100 splits, {RUNS} runs",
        "",
        *order_table(),
        "",
        "## Missing physics: a mirror whose gain drifts with temperature, and with play",
        "",
        *residual_table(),
        "",
        "## Missing physics: the Silverbox, trained on its training file, simulated freely on its tests",
        "",
    ]
    folder = os.environ.get("ARCSMITH_RECORDINGS")
    if folder:
        lines += silverbox_table(Path(folder))
        lines += ["", "Held-out errors are of the free run over the whole test file, its first 50 rows left out. "
                  "PySINDy is given velocity and acceleration by a Savitzky-Golay filter (9 points, order 4) and all "
                  "rows of the training file."]
    else:
        print("skipped: the Silverbox comparison needs ARCSMITH_RECORDINGS", file=sys.stderr)
        lines += ["Left out in this run: the recordings were not there."]
    page = ROOT / "docs/benchmarks.md"
    # What others wrote below stays.
    end = "<!-- The end of what compare.py writes. -->\n"
    kept = page.read_text().partition(end)[2] if page.exists() else ""
    page.write_text("\n".join(lines) + "\n\n" + end + kept)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
