"""The scripts of docs/fleet.md on Ray and on Spark: their rows are those of `arcsmith fleet`.

Ray runs on two workers, of which one is killed on the way; Spark where there is a Java runtime. `.ci/engines` runs this.
"""

import os
import re
import shutil
import signal
import sys
import threading
import time
from pathlib import Path

import pandas
import pyarrow
import pyarrow.dataset
import pytest

import arcsmith.fleet

PAGE = Path(__file__).parents[3] / "docs" / "fleet.md"
UNITS = int(os.environ.get("ARCSMITH_ENGINE_UNITS", "200"))


def script(engine):
    """The script of the page that imports this engine."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (found,) = [block for block in blocks if engine in block and "diagnose_batch" in block]
    return found


@pytest.fixture(scope="module")
def production(run):
    """A dataset of two files, with the rows and the seconds of `arcsmith fleet` on two cores."""
    effects = ("thermal_zero_drift:coefficient_arcsec_per_k=0.2", "backlash:half_width_arcsec=1.5", None)
    frames = []
    for seed in range(UNITS):
        effect = effects[seed % len(effects)]
        hidden = ("--effect", effect) if effect else ()
        words = ("--protocol", "calibration", "--seed", str(seed), "--temperature", "levels", *hidden)
        (run.folder / "u.csv").unlink(missing_ok=True)
        run("record", *words, "--out", "u.csv")
        frames.append(pandas.read_csv(run.folder / "u.csv").assign(serial=f"u{seed:05}"))
    (run.folder / "production").mkdir()
    half = len(frames) // 2
    for name, part in [("a", frames[:half]), ("b", frames[half:])]:
        pandas.concat(part, ignore_index=True).to_parquet(run.folder / "production" / f"{name}.parquet")
    seconds = {}
    for jobs in (1, 2):
        begun = time.perf_counter()
        words = ("--unit", "serial", "--mirror", "mirror.toml", "--jobs", str(jobs), "--out", f"results{jobs}")
        run("fleet", "production", *words)
        seconds[jobs] = time.perf_counter() - begun
    print("".join(f"\narcsmith fleet --jobs {jobs}: {UNITS / of:.1f} units per second" for jobs, of in seconds.items()))
    return run.folder, rows(run.folder / "results2" / "units"), seconds[2]


def rows(folder):
    """Rows by unit; the file is not known to an engine."""
    table = pyarrow.dataset.dataset(folder, exclude_invalid_files=True).to_table().drop_columns("file")
    return table.sort_by("unit").to_pylist()


def run_script(engine, folder, given):
    """Runs the script with its folder put in the place of the shared one; returns rows and seconds."""
    begun = time.perf_counter()
    exec(script(engine).replace("/shared", str(folder)), given)
    return rows(folder / "units"), time.perf_counter() - begun


def report(engine, seconds, own):
    print(f"\n{engine}: {UNITS / seconds:.1f} units per second, {1000 * (seconds - own) / UNITS:.0f} ms more per unit")


def workers():
    """Processes in which Ray runs a task of the script: their title begins with what they do."""
    for process in Path("/proc").iterdir():
        try:
            title = (process / "cmdline").read_bytes() if process.name.isdigit() else b""
        except OSError:
            continue
        if title.startswith(b"ray::") and b"Map" in title:
            yield int(process.name)


def kill_one(killed, done):
    """Kills the first worker that is seen at work, a second after."""
    while not done.is_set() and not killed:
        for worker in list(workers())[:1]:
            time.sleep(1)
            try:
                os.kill(worker, signal.SIGKILL)
                killed.append(worker)
            except ProcessLookupError:
                pass
        time.sleep(0.05)


def test_ray_gives_the_rows_of_the_program_though_a_worker_is_killed(production):
    ray = pytest.importorskip("ray")
    folder, expected, own = production
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        undisturbed, seconds = run_script("ray.data", folder, {})
        assert undisturbed == expected
        report("Ray", seconds, own)
        shutil.rmtree(folder / "units")
        killed, done = [], threading.Event()
        killer = threading.Thread(target=kill_one, args=(killed, done))
        killer.start()
        found, seconds = run_script("ray.data", folder, {})
        done.set()
        killer.join()
        assert killed, "no worker was seen at work"
        assert found == expected
    finally:
        ray.shutdown()
        shutil.rmtree(folder / "units", ignore_errors=True)


def test_spark_gives_the_rows_of_the_program(production):
    if not shutil.which("java"):
        pytest.skip("Spark: no Java runtime; on Debian `apt install default-jre-headless`")
    sql = pytest.importorskip("pyspark.sql")
    folder, expected, own = production
    os.environ["PYSPARK_PYTHON"] = sys.executable
    spark = sql.SparkSession.builder.master("local[2]").config("spark.ui.enabled", False).getOrCreate()
    try:
        found, seconds = run_script("spark", folder, {"spark": spark})
        assert found == expected
        report("Spark", seconds, own)
    finally:
        spark.stop()
        shutil.rmtree(folder / "units", ignore_errors=True)
