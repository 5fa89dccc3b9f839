#!/usr/bin/env python3
"""Arcsmith beside gplearn, PySINDy and a Gaussian process on physics that its catalogue lacks.

`arcsmith trials beyond` makes the recordings and Arcsmith's answers; every other method is given the same rows, and all
are tried on the same fresh recording of the device, in the same way. Writes beyond.md and beyond.json into the folder.
"""

import argparse
import itertools
import json
import os
import platform
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

# One thread each, so that times can be compared.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
import pandas as pd

warnings.filterwarnings("ignore")

ARCSEC = 180 * 3600 / np.pi
DISTANCE_MM = 12.0
# Time constants of the lagged copies: of what warms up, creeps or is swept within these recordings.
LAGS_S = (30.0, 120.0, 480.0)
FOLDS = 4
# `trials beyond` counts a recording as made worse from here on, and the gain as realised from there on.
WORSE, REALISED = 1.03, 0.9
ARCSMITH = "Arcsmith"


def processor_s():
    """Processor time of this process and of those that it started and waited for: what else runs does not count."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def timed(work):
    start = processor_s()
    result = work()
    return result, processor_s() - start


def mean_square(error):
    """About the mean: the zero of the reference is unknown."""
    return float(np.mean((error - error.mean()) ** 2))


# ---------------------------------------------------------------------------------------------- what a method is given


class Case:
    """A recording, the fresh one of the same device, and what the base alone leaves of both.

    Arrays of rows are those of the recording followed by those of the fresh one; `seen` says how many are the former.
    """

    def __init__(self, arcsmith, folder, row, scratch):
        self.arcsmith, self.folder, self.scratch = arcsmith, folder / row["device"], scratch
        self.file, self.row = row["recording"], row
        self.stem = self.file.removesuffix(".csv")
        self.recording, self.fresh = self.folder / "recordings" / self.file, self.folder / "fresh" / self.file
        tables = [pd.read_csv(path) for path in (self.recording, self.fresh)]
        self.seen = len(tables[0])
        self.mirror = "x1_mm" in tables[0]
        self.columns = [self.named(table) for table in tables]
        reading = np.concatenate([c["reading"] for c in self.columns])
        here = reading[: self.seen]
        # Beyond the recorded range no model promises anything.
        self.covered = (reading[self.seen :] >= here.min()) & (reading[self.seen :] <= here.max())
        base = self.folder / "fresh" / f"{self.stem}.base.json"
        self.corrected = self.apply_both(base)
        reference = "reference_arcsec" if self.mirror else "reference"
        self.reference = np.concatenate([table[reference] for table in tables])
        clean = pd.read_csv(self.folder / "fresh" / f"{self.stem}.clean.csv")[reference]
        self.scored = np.concatenate([tables[0][reference], clean])
        order = json.loads(base.read_text())["base"]["order"]
        self.base = np.polynomial.chebyshev.chebvander(reading / np.abs(here).max(), order)
        # What the base leaves, in units of its own size, which no method is told.
        left = (self.corrected - self.reference)[: self.seen]
        self.scale = left.std()
        self.target = (left - left.mean()) / self.scale
        passes = tables[0]["pass"].to_numpy()
        self.fold = np.searchsorted(np.unique(passes), passes) % FOLDS

    def named(self, table):
        """Reading, direction, time and every further column by name; the probes of a mirror as their common mode."""
        known = {"pass", "x1_mm", "x2_mm", "reference_arcsec", "measured", "reference", "t_s", "direction"}
        columns = {"reading": table.get("measured")}
        if self.mirror:
            columns["reading"] = ARCSEC * np.arctan((table["x2_mm"] - table["x1_mm"]) / DISTANCE_MM)
            columns["common_mode"] = (table["x1_mm"] + table["x2_mm"]) / 2
        columns["t_s"] = table["t_s"]
        if table["direction"].nunique() > 1:
            columns["direction"] = table["direction"]
        columns |= {name: table[name] for name in table if name not in known}
        return {name: np.asarray(values, float) for name, values in columns.items()}

    def features(self):
        """The columns, by the mean and spread of the recording, rows of the fresh one last; constants left out.

        Time stands at its mean in the fresh rows: what drifted in one recording does not drift so in another.
        """
        together = {}
        for name, here in self.columns[0].items():
            if here.std() > 0 and name in self.columns[1]:
                together[name] = np.concatenate([here, self.columns[1][name]])
        scaled = {name: (v - v[: self.seen].mean()) / v[: self.seen].std() for name, v in together.items()}
        scaled["t_s"][self.seen :] = 0.0
        return scaled

    def with_memory(self):
        """The same, and every further column behind one lag, for methods that many columns would drown."""
        features = self.features()
        further = [name for name in features if name not in ("reading", "direction", "t_s")]
        return features | self.lagged(further, LAGS_S[1:2])

    def lagged(self, names, lags_s=LAGS_S):
        """Every column behind a first-order lag, from its first value on, in the same units."""
        features, lagged = self.features(), {}
        for name in names:
            # Reading and direction are swept: of their longer past nothing but the schedule is left.
            for lag_s in lags_s[:1] if name in ("reading", "direction") else lags_s:
                parts = []
                for part, columns in zip((slice(0, self.seen), slice(self.seen, None)), self.columns):
                    values, t_s = features[name][part], columns["t_s"]
                    keep = np.exp(-np.diff(t_s, prepend=t_s[0]) / lag_s)
                    state = [values[0]]
                    for k, value in zip(keep[1:], values[1:]):
                        state.append(k * state[-1] + (1 - k) * value)
                    parts.append(state)
                lagged[f"{name} {lag_s:g}s"] = np.concatenate(parts)
        return lagged

    def apply(self, recording, coefficients):
        out = self.scratch / "applied.csv"
        command = [self.arcsmith, "apply", recording, "--coefficients", coefficients, "--out", out, "--quiet"]
        subprocess.run(command, check=True, capture_output=True)
        return pd.read_csv(out).iloc[:, 1].to_numpy()

    def apply_both(self, coefficients):
        return np.concatenate([self.apply(path, coefficients) for path in (self.recording, self.fresh)])

    def by(self, correction):
        """Mean square on the fresh recording beside the reference without its noise, as `trials beyond` has it."""
        error = (self.corrected - self.scale * correction - self.scored)[self.seen :]
        return mean_square(error[self.covered])


def joint(case, rows, columns=()):
    """Base and columns fitted together to rows of the recording by least squares: their value in every row."""
    design = np.column_stack([case.base, *columns])
    amplitudes = np.linalg.lstsq(design[: case.seen][rows], case.target[rows], rcond=1e-10)[0]
    return design @ amplitudes


def without_outliers(case, rows, correction):
    """The rows but for those that a first fit leaves further off than five standard deviations, robustly estimated."""
    left = case.target - correction[: case.seen]
    centre = np.median(left[rows])
    spread = 1.4826 * np.median(np.abs(left[rows] - centre))
    return rows & (np.abs(left - centre) < 5 * spread)


def base_alone(case, rows):
    return joint(case, rows)


# ------------------------------------------------------------------------------------------------- the other methods

PROGRAMS, GENERATIONS = 2000, 20


def gplearn_fit(case, rows):
    """Programs are judged by their correlation with the error where base and amplitude are fitted beside them."""
    from gplearn.fitness import make_fitness
    from gplearn.genetic import SymbolicRegressor

    x = np.column_stack(list(case.features().values()))
    inside = x[: case.seen][rows]
    free = np.linalg.qr(case.base[: case.seen][rows])[0]
    error = case.target[rows] - free @ (free.T @ case.target[rows])
    error = np.clip(error, -5 * robust(error), 5 * robust(error))

    def correlation(y, predicted, _):
        if len(predicted) != len(free) or not np.isfinite(predicted).all():
            return 0.0
        size = np.sqrt(predicted @ predicted)
        predicted = predicted - free @ (free.T @ predicted)
        left = np.sqrt(predicted @ predicted)
        # What the base takes all of is no program of its own.
        return float(abs(predicted @ y) / left / np.sqrt(y @ y)) if left > 1e-6 * size > 0 else 0.0

    evolution = SymbolicRegressor(
        population_size=PROGRAMS, generations=GENERATIONS, tournament_size=20, init_depth=(2, 5), const_range=(-2, 2),
        function_set=("add", "sub", "mul", "div", "sqrt", "abs", "sin", "cos"), parsimony_coefficient=1e-3,
        metric=make_fitness(function=correlation, greater_is_better=True, wrap=False), random_state=1,
    )
    evolution.fit(inside, error)
    value = evolution._program.execute(x)
    value = np.where(np.isfinite(value), value, 0.0)
    first = joint(case, rows, [value])
    return joint(case, without_outliers(case, rows, first), [value]), str(evolution._program)


def robust(values):
    return 1.4826 * np.median(np.abs(values - np.median(values)))


DEGREES, THRESHOLDS, RIDGES = (1, 2, 3), (0.02, 0.05, 0.1, 0.2, 0.4), (1e-4, 1e-2, 1e-1)


def library(case, degree):
    """The custom library: monomials of all columns; lagged copies of all, from degree 2 on also times reading and
    direction; direction times powers of the reading; sine and cosine of angles in degrees."""
    from pysindy import PolynomialLibrary

    features = case.features()
    polynomials = PolynomialLibrary(degree=degree, include_bias=False)
    names = list(features)
    monomials = np.asarray(polynomials.fit_transform(np.column_stack(list(features.values()))))
    terms = dict(zip(polynomials.get_feature_names(names), monomials.T))
    partners = [name for name in ("reading", "direction") if name in features and degree > 1]
    for name, values in case.lagged([name for name in features if name != "t_s"]).items():
        terms[name] = values
        terms |= {f"{name} {partner}": values * features[partner] for partner in partners}
    if "direction" in features:
        terms |= {f"direction reading^{n}": features["direction"] * features["reading"] ** n for n in range(1, 6)}
    for name, here in case.columns[0].items():
        if name.endswith("_deg"):
            angle = np.radians(np.concatenate([here, case.columns[1][name]]))
            for n in (1, 2, 3):
                terms |= {f"sin {n} {name}": np.sin(n * angle), f"cos {n} {name}": np.cos(n * angle)}
    return np.array(list(terms)), np.column_stack(list(terms.values()))


def pysindy_fit(case, rows):
    """STLSQ; degree, threshold and ridge are chosen by held-out passes, and the base is fitted beside every term."""
    import pysindy as ps

    memory = case.memory
    if not memory:
        memory["libraries"] = {degree: library(case, degree) for degree in DEGREES}

    def table(degree, rows):
        """The terms less what the base takes of them on these rows, of unit size there."""
        names, raw = memory["libraries"][degree]
        columns = raw - case.base @ np.linalg.lstsq(case.base[: case.seen][rows], raw[: case.seen][rows], rcond=1e-10)[0]
        spread = columns[: case.seen][rows].std(axis=0)
        kept = spread > 1e-3 * raw[: case.seen][rows].std(axis=0)
        return names[kept], columns[:, kept] / spread[kept]

    def found(columns, rows, threshold, ridge):
        left = (case.target - joint(case, rows)[: case.seen])[rows]
        left = np.clip(left, -5 * robust(left), 5 * robust(left))
        optimizer = ps.STLSQ(threshold=threshold, alpha=ridge * rows.sum())
        model = ps.SINDy(optimizer=optimizer, feature_library=ps.IdentityLibrary())
        model.fit(columns[: case.seen][rows], t=1.0, x_dot=left[:, None])
        return model.coefficients()[0] != 0

    def correction(columns, rows, chosen):
        picked = list(columns[:, chosen].T)
        first = joint(case, rows, picked)
        return joint(case, without_outliers(case, rows, first), picked)

    if "choice" not in memory:
        score = dict.fromkeys(itertools.product(DEGREES, THRESHOLDS, RIDGES), 0.0)
        for fold in np.unique(case.fold):
            inner, outer = case.fold != fold, case.fold == fold
            columns = {degree: table(degree, inner)[1] for degree in DEGREES}
            for choice in score:
                chosen = found(columns[choice[0]], inner, *choice[1:])
                left = (case.target - correction(columns[choice[0]], inner, chosen)[: case.seen])[outer]
                # Outliers are not to choose.
                left = np.minimum(np.abs(left - np.median(left)), 5 * robust(left))
                score[choice] += float(left @ left)
        memory["choice"] = min(score, key=score.get)
    degree, threshold, ridge = memory["choice"]
    names, columns = table(degree, rows)
    chosen = found(columns, rows, threshold, ridge)
    return correction(columns, rows, chosen), ", ".join(names[chosen]) or "nothing"


MOST_ROWS = 400


def gaussian_fit(case, rows):
    """ARD kernel of all columns but time, a kernel of time alone, and white noise. The part of time is fitted and not
    applied: another recording has another drift. Marginal likelihood of at most MOST_ROWS rows, conditioned on all."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    features = case.with_memory()
    time = np.array([name == "t_s" for name in features])
    x = np.column_stack(list(features.values()))
    base = joint(case, rows)
    left = case.target - base[: case.seen]
    process = lambda kernel, **how: GaussianProcessRegressor(kernel, random_state=1, **how)
    if not case.memory:
        some = np.flatnonzero(rows)
        if len(some) > MOST_ROWS:
            some = np.random.default_rng(1).choice(some, MOST_ROWS, replace=False)

        def part(of, size, start, least):
            # A column that is not of this part has a length without end.
            lengths, bounds = np.where(of, start, 1e6), [(least, 1e3) if its else (1e6 - 1, 1e6 + 1) for its in of]
            return ConstantKernel(size, (1e-4, 1e3)) * RBF(lengths, bounds)

        kernel = part(~time, 0.5, 2.0, 5e-2) + part(time, 0.1, 0.1, 3e-3) + WhiteKernel(0.3, (1e-5, 1e1))
        limited = np.clip(left[some], -5 * robust(left[some]), 5 * robust(left[some]))
        case.memory["kernel"] = process(kernel).fit(x[some], limited).kernel_
    kernel = case.memory["kernel"]
    lasting = kernel.k1.k1

    def conditioned(kept):
        return process(kernel, optimizer=None).fit(x[: case.seen][kept], left[kept])

    # Outliers are told by what the process itself leaves.
    first = conditioned(rows).predict(x[: case.seen])
    kept = without_outliers(case, rows, base + np.concatenate([first, np.zeros(len(x) - case.seen)]))
    fitted = conditioned(kept)
    values = lasting(x, fitted.X_train_) @ fitted.alpha_
    depends = sorted((length, name) for name, length in zip(features, lasting.k2.length_scale) if length < 100)
    said = ", ".join(f"{name} ({length:.2g})" for length, name in depends)
    return base + values, said or "nothing"


METHODS = {"gplearn": gplearn_fit, "PySINDy": pysindy_fit, "Gaussian process": gaussian_fit}

# ------------------------------------------------------------------------------------------------------------ scoring


def tried(case, fit):
    """A method on a recording: its mean square on the fresh one, on held-out passes, and whether these would use it."""
    case.memory = {}
    (correction, said), taken = timed(lambda: fit(case, np.ones(case.seen, bool)))
    left, held_out = {"it": 0.0, "base": 0.0}, None
    start = processor_s()
    for fold in np.unique(case.fold):
        rows, out = case.fold != fold, case.fold == fold
        by = {"it": fit(case, rows)[0], "base": base_alone(case, rows)}
        errors = {name: (case.target - value[: case.seen])[out] for name, value in by.items()}
        if fold == FOLDS - 1 or held_out is None:
            held_out = float(np.sqrt(mean_square(errors["it"]) / mean_square(errors["base"])))
        limit = 5 * robust(errors["base"])
        for name, error in errors.items():
            left[name] += float(np.sum(np.minimum(np.abs(error - np.median(error)), limit) ** 2))
    checked = processor_s() - start
    return {
        "fresh": case.by(correction), "helps": left["it"] < left["base"], "held_out": held_out, "said": said,
        "seconds": taken + checked,
    }


def arcsmith_tried(case, mirror):
    """Arcsmith's answer as the campaign has it, its time, and its held-out passes by a diagnosis without them."""
    handed_on = case.folder / "diagnosed" / f"{case.stem}.coefficients.json"
    if not handed_on.is_file():
        handed_on = case.folder / "fresh" / f"{case.stem}.base.json"
    error = (case.apply(case.fresh, handed_on) - case.scored[case.seen :])[case.covered]
    out = np.isin(case.fold, FOLDS - 1 if (case.fold == FOLDS - 1).any() else 0)

    def diagnose(recording):
        command = [case.arcsmith, "diagnose", recording, "--mirror", mirror, "--out", case.scratch / "out", "--no-report"]
        subprocess.run(command, check=False, capture_output=True)

    _, taken = timed(lambda: diagnose(case.recording))
    part = case.scratch / "part.csv"
    lines = case.recording.read_text().splitlines(keepends=True)
    part.write_text(lines[0] + "".join(line for line, gone in zip(lines[1:], out) if not gone))
    (case.scratch / "out" / "part.coefficients.json").unlink(missing_ok=True)
    diagnose(part)
    by_part = case.scratch / "out" / "part.coefficients.json"
    base = (case.target - base_alone(case, ~out)[: case.seen])[out]
    held_out = 1.0
    if by_part.is_file():
        left = (case.apply(case.recording, by_part) - case.reference[: case.seen])[out] / case.scale
        held_out = float(np.sqrt(mean_square(left) / mean_square(base)))
    return {"fresh": mean_square(error), "held_out": held_out, "said": case.row["said"], "seconds": taken}


def entry(case, methods):
    """The row of a recording in the JSON."""
    truth, fresh = case.row, case.row["fresh"]
    zero = case.by(np.zeros(len(case.reference)))
    # The campaign's own figures come out again, or this comparison is none.
    for ours, theirs in [(zero, fresh["base"]), (methods[ARCSMITH]["fresh"], fresh["handed_on"])]:
        if abs(ours / theirs - 1) > 1e-3:
            sys.exit(f"{case.file}: {ours} by this script, {theirs} by the campaign")
    gain = lambda value: (fresh["base"] - value) / (fresh["base"] - fresh["oracle"])
    judged = {}
    for name, result in methods.items():
        judged[name] = result | {"gain": gain(result["fresh"]), "ratio": (result["fresh"] / fresh["base"]) ** 0.5}
        if "helps" in result:
            value = result["fresh"] if result["helps"] else fresh["base"]
            judged[f"{name}, or nothing"] = {
                "fresh": value, "gain": gain(value), "ratio": (value / fresh["base"]) ** 0.5, "seconds": result["seconds"]
            }
    names = ("recording", "device", "kind", "family", "condition", "rho", "rows")
    return {name: truth[name] for name in names} | {"fresh": fresh, "methods": judged}


def summary(entries):
    table = []
    for name in entries[0]["methods"]:
        results = [entry["methods"][name] for entry in entries]
        gains = [result["gain"] for result in results]
        held_out = [result["held_out"] for result in results if "held_out" in result]
        share = lambda hits: sum(hits) / len(results)
        table.append({
            "method": name, "median_gain": statistics.median(gains),
            "realised": share(gain >= REALISED for gain in gains),
            "worse": share(result["ratio"] > WORSE for result in results),
            "held_out": statistics.median(held_out) if held_out else None,
            "seconds": statistics.median(result["seconds"] for result in results),
        })
    return table


def markdown(table):
    lines = [
        "| | median gain | nine tenths of the gain | made worse (> 3 %) | held-out passes, rms over the base's | time |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for row in table:
        held_out = "" if row["held_out"] is None else f"{row['held_out']:.2f}"
        lines.append(
            f"| {row['method']} | {100 * row['median_gain']:.1f} % | {100 * row['realised']:.0f} % "
            f"| {100 * row['worse']:.0f} % | {held_out} | {row['seconds']:.1f} s |"
        )
    return "\n".join(lines) + "\n"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("arcsmith", type=Path, help="the program")
    options.add_argument("--seed", type=int, default=1, help="of the recordings and of the choice among them")
    options.add_argument("--count", type=int, default=40, help="recordings")
    options.add_argument("--trials", type=int, default=2, help="recordings of each kind that are made")
    options.add_argument("--out", type=Path, default=Path("target/compare-beyond"), help="folder")
    options.add_argument("--made", action="store_true", help="the folder holds the campaign of this seed already")
    asked = options.parse_args()
    arcsmith, out = asked.arcsmith.resolve(), asked.out.resolve()
    campaign = [arcsmith, "trials", "beyond", "--trials", asked.trials, "--nulls", 0, "--motion", 0]
    campaign += ["--seed", asked.seed, "--jobs", 1, "--out", out, "--quiet"]
    # Exit code 1: a figure misses its target.
    code = 0 if asked.made else subprocess.run([str(word) for word in campaign], check=False).returncode
    if code not in (0, 1):
        sys.exit(f"the campaign ended with {code}")
    report = out / "report.json"
    rows = json.loads(report.read_text())["rows"]
    counted = sorted((row for row in rows if row["gain"] is not None), key=lambda row: row["recording"])
    chosen = random.Random(asked.seed).sample(counted, min(asked.count, len(counted)))
    mirrors = {"mirror": "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n[reference]\naccuracy_arcsec = 1.0\n",
               "sensor": '[sensor]\nkind = "direct"\nunit = "mm"\n'}
    entries = []
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        for number, row in enumerate(sorted(chosen, key=lambda row: row["recording"]), 1):
            stated = scratch / f"{row['device']}.toml"
            stated.write_text(mirrors[row["device"]])
            case = Case(arcsmith, out, row, scratch)
            methods = {ARCSMITH: arcsmith_tried(case, stated)}
            methods |= {name: tried(case, fit) for name, fit in METHODS.items()}
            entries.append(entry(case, methods))
            gains = ", ".join(f"{name} {result['gain']:.2f}" for name, result in entries[-1]["methods"].items())
            print(f"{number}/{len(chosen)} {row['recording']} {row['kind']}: {gains}", file=sys.stderr, flush=True)
    table = summary(entries)
    packages = {name: version(name) for name in ("numpy", "scikit-learn", "gplearn", "pysindy")}
    made = {"command": " ".join(str(word) for word in sys.argv[1:]), "python": platform.python_version()} | packages
    (out / "beyond.json").write_text(json.dumps({"made": made, "summary": table, "recordings": entries}, indent=1))
    (out / "beyond.md").write_text(markdown(table))
    print(markdown(table), end="")


if __name__ == "__main__":
    main()
