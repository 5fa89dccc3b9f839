#!/usr/bin/env python3
"""Proven bounds of Arcsmith's routines beside those of coefficients by Sollya's fpminimax, with the rounding by Gappa.

The function, the formats of the coefficients, the ranges and the order of the operations are the same for both: they are
read off the routine that was generated. Sollya gives coefficients and the supremum of their distance (`supnorm`), Gappa
the rounding of the same Horner scheme. Of two targets, with and without the mean of the truncations, the better counts.

    python3 benches/compare/expert/expert.py --devices 50 --seed 1 --formats q31,table,f32 --write
    cargo run --release -p firmware-tests -- compare

Needs sollya 8, gappa 1.4 and target/release/codegen.
"""

import argparse
import json
import math
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
RELEASE = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
ARCSEC = 180 * 3600 / math.pi
PAPER = [-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4]
DEGREES = range(5, 11)
TABLES = ["1x64", "2x32", "3x16"]
SECONDS = 300


class Device:
    """Probe distance, range and coefficients of Eq. 12."""

    def __init__(self, name, distance, start, end, coefficients):
        self.name, self.distance, self.start, self.end, self.coefficients = name, distance, start, end, coefficients

    def file(self, folder):
        """Writes its coefficients file."""
        path = Path(folder) / f"{self.name}.json"
        path.write_text(json.dumps({
            "schema": "arcsmith-coefficients", "version": 1, "tool": "expert.py", "command": "expert.py",
            "recording": {"file": "drawn", "sha256": "", "rows": 0, "passes": 0},
            "sensor": {"kind": "eddy-current-pair", "probe_distance_mm": self.distance, "initial_gap_mm": 0.3},
            "units": {"reading": "mm", "error": "rad", "statistics": "arcsec"},
            "valid_range": {"variable": "s_mm", "from": self.start, "to": self.end},
            "base": {"order": len(self.coefficients) - 1, "centre": 0.0, "coefficients": self.coefficients,
                     "extrapolation": {"constant": 0.0, "slope": 0.0}},
            "terms": [], "observed": {},
        }))
        return path


def devices(count, seed):
    """The paper's device and `count` others: its coefficients times -2 to 2, other ranges and probe distances."""
    draw = random.Random(seed)
    yield Device("paper", 12.0, -0.38, 0.38, PAPER)
    for i in range(count):
        start, end = -draw.uniform(0.3, 0.4), draw.uniform(0.3, 0.4)
        coefficients = [a * draw.uniform(-2, 2) for a in PAPER]
        yield Device(f"random_{i + 1}", draw.uniform(10, 14), start, end, coefficients)


class Ours:
    """A generated routine: its bound and what the expert needs to know of its formats."""

    def __init__(self, device, file, folder, kind, what, fma=False):
        out = Path(folder) / f"{device.name}_{kind}_{what}"
        command = [RELEASE / "codegen", "--coefficients", file, "--format", kind, "--bound-arcsec", "100000", "--quiet",
                   "--out", out]
        command += ["--table", what] if "x" in str(what) else ["--degree", str(what)]
        command += ["--fma"] if fma else []
        subprocess.run(command, check=True, capture_output=True, timeout=SECONDS)
        entry = json.loads((out / "certificate.json").read_text())["routines"][0]
        self.bound, self.best, self.degree = entry["bound"], entry["minimax"], entry["degree"]
        self.fraction_bits = entry["output"]["fraction_bits"]
        self.approximation = sum(part["value"] for part in entry["parts"][:2])
        self.source = with_constants((out / "c" / "corrected_angle.c").read_text())
        limits = re.search(r"limit_\w+\(\w+, (-?\w+(?:\.\w+)?(?:p-?\d+)?)f?, (-?\w+(?:\.\w+)?(?:p-?\d+)?)f?\)", self.source)
        self.limits = limits.groups() if limits else None


def with_constants(source):
    """The source with every constant in place of its number in their array."""
    array = re.search(r"constants\[\d+\] = \{([^}]*)\}", source)
    values = array[1].replace("INT32_MIN", "-2147483648").split(",") if array else []
    return re.sub(r"\bconstant\[(\d+)\]", lambda place: values[int(place[1])].strip(), source)


def sollya(device, calls):
    """Runs calls of expert.sollya's procedures; for each the candidates as (coefficients, distance)."""
    numbers = ", ".join(float(a).hex() for a in device.coefficients)
    script = "prec = 300; display = hexadecimal; verbosity = 0;\n"
    script += (HERE / "expert.sollya").read_text()
    script += f"a = [|{numbers}|]; d = {float(device.distance).hex()};\n" + "".join(call + ";\n" for call in calls)
    run = subprocess.run(["sollya", "--warnonstderr"], input=script + "quit;\n", text=True, capture_output=True,
                         timeout=SECONDS)
    groups, group = [], []
    for line in run.stdout.splitlines():
        words = line.split()
        if line.startswith("candidate"):
            *coefficients, _, distance = words[2:]
            group.append(([float.fromhex(c) for c in coefficients], float.fromhex(distance)))
        elif line.startswith("end"):
            groups.append(group)
            group = []
    if len(groups) != len(calls):
        sys.exit(f"sollya: {len(groups)} of {len(calls)} calls: {run.stdout[-500:]}{run.stderr[-500:]}")
    return groups


def gappa(script):
    """The largest magnitude of the one goal `... in ?`."""
    run = subprocess.run(["gappa"], input=script, text=True, capture_output=True, timeout=SECONDS)
    # Behind each end stands what it is about, in braces.
    told = re.sub(r" \{[^}]*\}", "", run.stdout + run.stderr)
    ends = re.search(r"in \[(-?\d+)(b-?\d+)?, (-?\d+)(b-?\d+)?\]", told)
    if not ends:
        sys.exit(f"gappa: {run.stdout}{run.stderr}\n{script}")
    value = lambda m, e: abs(Fraction(int(m)) * Fraction(2) ** int((e or "b0")[1:]))
    return float(max(value(*ends.groups()[:2]), value(*ends.groups()[2:])))


def fixed_rounding(coefficients, shifts, start, end, variable="x_"):
    """Rounding of Horner's scheme by high words of products, about its mean, in units of the last place."""
    lines = ["@floor = fixed<0, dn>;", f"{variable} = floor(any_);"]
    hints, before, last = [], str(coefficients[-1]), None
    for k in range(len(coefficients) - 2, -1, -1):
        c, exact = coefficients[k], f"e_{last}" if last is not None else before
        factor = shifts[k]
        lines += [f"z_{k} = {before} * {variable} * 1b-32;", f"r_{k} = floor(z_{k}) * {factor} + {c};",
                  f"e_{k} = ({exact} * {variable} * 1b-32 - 0.5) * {factor} + {c};"]
        carried = f" + (r_{last} - e_{last}) * {variable} * {factor} * 1b-32" if last is not None else ""
        hints.append(f"r_{k} - e_{k} -> ((floor(z_{k}) - z_{k}) + 0.5) * {factor}{carried};")
        before, last = f"r_{k}", k
    goal = f"{{ {variable} in [{start}, {end}] -> r_0 - e_0 in ? }}"
    return gappa("\n".join(lines + [goal] + hints) + "\n")


def float_rounding(coefficients, start, end, pieces, fma):
    """Rounding of Horner's scheme in floats, products and sums each, or once for both."""
    lines = ["@rnd = float<ieee_32, ne>;", "x_ = rnd(any_);"]
    hints, before, last = [], float(coefficients[-1]).hex(), None
    for k in range(len(coefficients) - 2, -1, -1):
        c, exact = float(coefficients[k]).hex(), f"e_{last}" if last is not None else before
        product = f"p_{k}" if fma else f"rnd(p_{k})"
        lines += [f"p_{k} = {before} * x_;", f"s_{k} = {product} + {c};", f"r_{k} = rnd(s_{k});",
                  f"e_{k} = {exact} * x_ + {c};"]
        own = "" if fma else f" + (rnd(p_{k}) - p_{k})"
        carried = f" + (r_{last} - e_{last}) * x_" if last is not None else ""
        hints.append(f"r_{k} - e_{k} -> (r_{k} - s_{k}){own}{carried};")
        before, last = f"r_{k}", k
    goal = f"{{ x_ in [{start}, {end}] -> r_0 - e_0 in ? }}"
    return gappa("\n".join(lines + [goal] + hints + [f"$ x_ in {pieces};"]) + "\n")


def dyadic(m, exponent):
    """m * 2^exponent, as Sollya reads it."""
    return f"({m}) * 2^({exponent})"


def expert_fixed(device, ours):
    """The expert's bound of one polynomial in fixed point, in arcsec."""
    # What is tried: the generated routine's binary points, and the coarsest of them for all.
    # From the highest coefficient down: the shift to the left after each product, and the binary point of what is added.
    steps = re.findall(r"int32_t y = .*|^ +y = .*", ours.source, re.M)
    shifts = [int(s[1]) if (s := re.search(r"\) \* (\d+)\)", step)) else 1 for step in steps][::-1]
    points = [int(re.search(r"in 2\^-(\d+)", step)[1]) for step in steps][::-1]
    points.append(points[-1] - int(math.log2(shifts[-1])))
    totals = [fixed_total(device, ours, points, shifts)]
    if len(set(points)) > 1:
        totals.append(fixed_total(device, ours, [min(points)] * len(points), [1] * len(shifts)))
    return min(totals)


def fixed_total(device, ours, points, shifts):
    """The expert's bound with these binary points, constant first."""
    start, end = (int(word) for word in ours.limits)
    scale = 2 * 2 ** math.ceil(math.log2(max(-device.start, device.end)))
    bias = " - ".join(f"2^(-{points[k + 1] + 1}) * x^{k}" for k in range(ours.degree))
    over = f"[{dyadic(start, -32)}, {dyadic(end, -32)}]"
    formats = ", ".join(map(str, points))
    call = f"fixed_point(angle(x * ({scale}), d, a), {ours.degree}, [|{formats}|], {over}, -{bias})"
    totals = []
    for coefficients, distance in sollya(device, [call])[0]:
        coefficients += [0.0] * (ours.degree + 1 - len(coefficients))
        words = [int(c * 2.0 ** point) for c, point in zip(coefficients, points)]
        rounding = fixed_rounding(words, shifts, start, end)
        totals.append(ARCSEC * (distance + rounding * 2.0 ** -points[0]))
    return min(totals)


def expert_float(device, ours, pieces, fma):
    """The expert's bound of one polynomial in floats, in arcsec; no two-part coefficient."""
    start, end = ours.limits
    over = f"[{start}, {end}]"
    formats = ", ".join(["24"] * (ours.degree + 1))
    call = f"floating_point(angle(x, d, a), {ours.degree}, [|{formats}|], {over})"
    (coefficients, distance), = sollya(device, [call])[0]
    return ARCSEC * (distance + float_rounding(coefficients, start, end, pieces, fma))


def segments(source, start, end):
    """Smallest and largest word of every segment between two ends."""
    if index := re.search(r"\(\(uint32_t\)x \+ (\d+)u\) >> (\d+)", source):
        add, by = int(index[1]), int(index[2])
    elif index := re.search(r"int32_t segment = shift_right\(x, (\d+)u\)", source):
        add, by = 0, int(index[1])
    else:
        raise NotImplementedError("a table whose segments are not of x")
    rows = range((start + add) >> by, ((end + add) >> by) + 1)
    return [(max(start, (row << by) - add), min(end, ((row + 1) << by) - add - 1)) for row in rows]


def expert_table(device, ours):
    """The expert's bound of a table of polynomials of the whole variable in fixed point, in arcsec: of its worst segment."""
    if re.search(r"= to_signed\(", ours.source):
        raise NotImplementedError("a table of polynomials of the place in the segment")
    degree, point = ours.degree, ours.fraction_bits
    ends = segments(ours.source, *(int(word) for word in ours.limits))
    scale = 2 * 2 ** math.ceil(math.log2(max(-device.start, device.end)))
    bias = f"-2^(-{point + 1}) * ({' + '.join(f'x^{k}' for k in range(degree))})"
    formats = ", ".join([str(point)] * (degree + 1))
    calls = [f"fixed_point(angle(x * ({scale}), d, a), {degree}, [|{formats}|], "
             f"[{dyadic(first, -32)}, {dyadic(max(last, first + 1), -32)}], {bias})" for first, last in ends]
    worst = 0.0
    for candidates, over in zip(sollya(device, calls), ends):
        coefficients, distance = min(candidates, key=lambda candidate: candidate[1])
        words = [round(c * 2.0 ** point) for c in coefficients]
        words += [0] * (degree + 1 - len(words))
        worst = max(worst, distance + fixed_rounding(words, [1] * len(words), *over) * 2.0 ** -point)
    return ARCSEC * worst


def compare(task):
    """One row: our bound, the best polynomial's distance, the expert's bound, or why there is none."""
    device, kind, what, arguments = task
    with tempfile.TemporaryDirectory() as folder:
        file = device.file(folder)
        fma = kind == "f32-fma"
        ours = Ours(device, file, folder, kind.split("-")[0], what, fma)
        try:
            if fma or kind == "f32":
                theirs = expert_float(device, ours, arguments.pieces, fma)
            elif "x" in str(what):
                theirs = expert_table(device, ours)
            else:
                theirs = expert_fixed(device, ours)
        except NotImplementedError as why:
            return ours.bound, ours.best, None, str(why)
    return ours.bound, ours.best, theirs, ""


class Kept:
    """Rows that were computed before, and a file that takes every further one as soon as it is known."""

    def __init__(self, path, seed):
        self.path, self.seed, self.rows = path, seed, {}
        if path and path.exists():
            for line in path.read_text().splitlines():
                *case, row = json.loads(line)
                self.rows[tuple(case)] = row

    def row(self, task):
        """The row of a task, computed unless it is there."""
        device, kind, what, _ = task
        case = (self.seed, device.name, kind, what)
        if case not in self.rows:
            self.rows[case] = compare(task)
            if self.path:
                with self.path.open("a") as file:
                    file.write(json.dumps([*case, self.rows[case]]) + "\n")
        return self.rows[case]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--devices", type=int, default=50, help="random devices beside the paper's")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--formats", default="q31,f32", help="of q31, f32, f32-fma, table")
    parser.add_argument("--degrees", default=",".join(map(str, DEGREES)))
    parser.add_argument("--pieces", type=int, default=64, help="into which Gappa cuts the range of a float")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--write", action="store_true", help="write bounds.json, from which docs/comparison.md is made")
    parser.add_argument("--rows", type=Path, help="file of the rows: what it holds of this seed is not computed again")
    arguments = parser.parse_args()
    tasks = []
    for device in devices(arguments.devices, arguments.seed):
        for kind in arguments.formats.split(","):
            cases = TABLES if kind == "table" else [int(d) for d in arguments.degrees.split(",")]
            tasks += [(device, "q31" if kind == "table" else kind, what, arguments) for what in cases]
    found = []
    print(f"{'device':<12} {'format':<8} {'degree':<7} {'ours':>12} {'expert':>12} {'ratio':>8} {'best of degree':>15}")
    with ThreadPoolExecutor(arguments.threads) as pool:
        kept = Kept(arguments.rows, arguments.seed)
        for (device, kind, what, _), (bound, best, theirs, why) in zip(tasks, pool.map(kept.row, tasks)):
            name = device.name
            if theirs is None:
                print(f"{name:<12} {kind:<8} {what!s:<7} {bound:12.5e} not compared: {why}", flush=True)
                continue
            found.append((name, kind, str(what), bound, theirs, best))
            print(f"{name:<12} {kind:<8} {what!s:<7} {bound:12.5e} {theirs:12.5e} {bound / theirs:8.4f} {best:15.5e}",
                  flush=True)
    totals = [dict(one, devices=str(arguments.devices), seed=str(arguments.seed)) for one in summaries(found)]
    for one in totals:
        print("{format}, {form}: {cases} cases, at most 1.00 in {within}, median {median}, smallest {smallest}, "
              "largest {largest}".format(**one))
    if arguments.write:
        paper = [dict(format=kind, what=what, ours=f"{bound:.3g}", expert=f"{theirs:.3g}", best=f"{best:.3g}",
                      ratio=f"{bound / theirs:.3f}")
                 for name, kind, what, bound, theirs, best in found if name == "paper"]
        write(dict(summaries=totals, paper=paper))


def write(content):
    """Writes bounds.json; formats and forms that were not computed now stay as they are."""
    path = HERE / "bounds.json"
    kept = json.loads(path.read_text()) if path.exists() else dict(summaries=[], paper=[])
    for part, key in (("summaries", ("format", "form")), ("paper", ("format", "what"))):
        rows = {tuple(row[k] for k in key): row for row in kept[part] + content[part]}
        content[part] = list(rows.values())
    path.write_text(json.dumps(content, indent=1) + "\n")


def summaries(found):
    """Of each format and form how many ratios there are, how many are at most 1, and their spread."""
    ratios = {}
    for _, kind, what, bound, theirs, _ in found:
        ratios.setdefault((kind, "table" if "x" in what else "polynomial"), []).append(bound / theirs)
    return [dict(format=kind, form=form, cases=str(len(values)), within=str(sum(r <= 1.0 for r in values)),
                 median=f"{statistics.median(values):.4f}", smallest=f"{min(values):.4f}", largest=f"{max(values):.4f}")
            for (kind, form), values in ratios.items()]


if __name__ == "__main__":
    main()
