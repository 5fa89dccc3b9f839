"""Memory, threads and time."""

import subprocess
import sys
import threading
import time

import arcsmith
import numpy
import pandas

ROWS = 1_000_000
# So many columns beside those that are needed: their numbers would be noticed.
FURTHER = 24

# Of this process alone: what `getrusage` gives is inherited from the one that started it.
PEAK = """
def peak():
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024
"""

MEMORY = f"""
import sys
import numpy, pyarrow, arcsmith
rows, further = {ROWS}, {FURTHER}
angle = numpy.linspace(-0.35, 0.35, rows)
column = lambda values: pyarrow.array(numpy.asarray(values, dtype=float))
columns = {{"t_s": column(numpy.arange(rows)), "x1_mm": column(-angle / 2), "x2_mm": column(angle / 2)}}
columns |= {{f"c{{k}}_v": column(numpy.full(rows, float(k))) for k in range(further)}}
table = pyarrow.table(columns)
{PEAK}before = peak()
arcsmith.apply(table, sys.argv[1])
print(peak() - before)
"""


def test_a_million_rows_are_not_copied(folder):
    arcsmith.fit("calibration.csv", "mirror.toml").write("coefficients.json")
    done = subprocess.run([sys.executable, "-c", MEMORY, "coefficients.json"], capture_output=True, text=True, check=True)
    grown, held = float(done.stdout), 8 * (3 + FURTHER) * ROWS / 2**20
    print(f"\n{ROWS} rows of {held:.0f} MiB: the peak grows by {grown:.0f} MiB")
    # Three columns of the result, and what the model is evaluated into; the table itself would be much more.
    assert grown < 0.5 * held


# A motion costs more work by row: fewer rows, and more columns beside.
MOTION_ROWS, MOTION_FURTHER = 20_000, 400

MOTION_MEMORY = f"""
import numpy, pyarrow, arcsmith
rows, further = {MOTION_ROWS}, {MOTION_FURTHER}
units = {{"kind": "second-order", "position_unit": "arcsec", "drive_unit": "A"}}
random = numpy.random.default_rng(1)
moved = {{"t_s": numpy.arange(rows) / 2000, "drive": 0.02 * random.standard_normal(rows)}}
plant = {{"plant": units | {{"damping": 32.0, "stiffness": 21000.0, "gain": 3e8}}}}
moved["position"] = numpy.array(arcsmith.simulate(moved, plant)["position"]) + random.standard_normal(rows)
column = lambda values: pyarrow.array(numpy.asarray(values, dtype=float))
columns = {{name: column(values) for name, values in moved.items()}}
table = pyarrow.table(columns | {{f"c{{k}}_v": column(numpy.full(rows, float(k))) for k in range(further)}})
{PEAK}before = peak()
assert arcsmith.diagnose(table, plant={{"plant": units}}).verdict == "consistent"
print(peak() - before)
"""


def test_a_motion_is_not_copied():
    done = subprocess.run([sys.executable, "-c", MOTION_MEMORY], capture_output=True, text=True, check=True)
    grown, held = float(done.stdout), 8 * (3 + MOTION_FURTHER) * MOTION_ROWS / 2**20
    print(f"\nmotion of {MOTION_ROWS} rows, {held:.0f} MiB: the peak grows by {grown:.0f} MiB")
    # What the search needs for a drive and a position; the table itself would be much more.
    assert grown < 0.5 * held


def test_other_threads_go_on(folder, columns):
    many = {name: numpy.tile(values, 200) for name, values in columns.items()}
    many["pass"] = numpy.repeat(numpy.arange(200), 210) * 6 + many["pass"]
    many["t_s"] = numpy.arange(len(many["pass"]), dtype=float)
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    other = threading.Thread(target=tick)
    other.start()
    begun = time.perf_counter()
    arcsmith.fit(many, "mirror.toml")
    ended = time.perf_counter()
    done.set(), other.join()
    during = [begun, *(at for at in ticks if begun < at < ended), ended]
    longest = max(b - a for a, b in zip(during, during[1:]))
    # Handing the columns over needs Python; the work does not.
    assert longest < 0.5 * (ended - begun), (longest, ended - begun)


def test_results_from_several_threads_are_the_same(folder):
    results = [None] * 4

    def work(k):
        results[k] = arcsmith.fit("calibration.csv", "mirror.toml", order=5 + k % 2).coefficients.to_json()

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert results[0] == results[2] and results[1] == results[3] and results[0] != results[1]


def test_a_table_costs_no_time(folder, columns):
    """`diagnose` of a table against the same of a file, which is the Rust library alone."""
    frame = pandas.DataFrame(columns)

    def once(recording):
        begun = time.process_time()
        arcsmith.diagnose(recording, "mirror.toml")
        return time.process_time() - begun

    # The time of all threads of this process: what else the machine does is left out.
    pairs = [(once("calibration.csv"), once(frame)) for _ in range(25)]
    of_file, of_table = (min(times) for times in zip(*pairs))
    print(f"\ndiagnose of 210 rows: file {1e3 * of_file:.1f} ms, pandas {1e3 * of_table:.1f} ms")
    assert of_table < 1.2 * of_file
