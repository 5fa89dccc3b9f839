"""Whatever hands a recording over, the same comes out."""

import datetime
import warnings

import arcsmith
import duckdb
import numpy
import pandas
import polars
import pyarrow
import pytest


def as_duckdb(columns):
    frame = pandas.DataFrame(columns)
    return duckdb.sql("from frame")


KINDS = {
    "lists": dict,
    "numpy": lambda columns: {name: numpy.array(values) for name, values in columns.items()},
    "pandas": pandas.DataFrame,
    "series": lambda columns: dict(pandas.DataFrame(columns).items()),
    "polars": polars.DataFrame,
    "pyarrow": pyarrow.table,
    "batches": lambda columns: pyarrow.Table.from_batches(pyarrow.table(columns).to_batches(max_chunksize=50)),
    "record batch": lambda columns: pyarrow.record_batch(columns),
    "duckdb": as_duckdb,
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_from_every_library(folder, columns, kind):
    expected = arcsmith.fit(columns, "mirror.toml").coefficients.to_json()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert arcsmith.fit(KINDS[kind](columns), "mirror.toml").coefficients.to_json() == expected


def test_the_same_numbers_as_the_file(folder, columns):
    of_file = arcsmith.fit("calibration.csv", "mirror.toml").to_dict()
    of_table = arcsmith.fit(columns, "mirror.toml", name="calibration.csv").to_dict()
    # The hash of a file is one of bytes, that of a table one of names and numbers.
    assert of_file["recording"].pop("sha256") != of_table["recording"].pop("sha256")
    assert of_table == of_file


def test_columns_of_whole_and_single_precision_numbers(folder, columns):
    frame = pandas.DataFrame(columns).astype({"pass": "int16", "direction": "int8"})
    whole = frame.assign(coil_a=numpy.round(100 * frame["coil_a"]).astype("int32"))
    assert arcsmith.fit(whole, "mirror.toml").order == 9
    single = polars.DataFrame(columns).with_columns(polars.col("temperature_c").cast(polars.Float32))
    # The shortest decimal of a single-precision number is what was meant.
    assert arcsmith.fit(single, "mirror.toml").coefficients.to_json() == (
        arcsmith.fit(columns, "mirror.toml").coefficients.to_json()
    )


@pytest.mark.parametrize("kind", ["pandas", "polars", "numpy", "lists"])
def test_timestamps_become_seconds_and_it_is_said(folder, columns, kind):
    start = datetime.datetime(2025, 3, 1, 8)
    stamps = [start + datetime.timedelta(seconds=t) for t in columns["t_s"]]
    if kind == "numpy":
        given = columns | {"t_s": numpy.array(stamps, dtype="datetime64[us]")}
    else:
        given = KINDS[kind](columns | {"t_s": stamps})
    said = "column `t_s` holds timestamps: taken as seconds since its first row"
    with pytest.warns(UserWarning, match="timestamps"):
        fit = arcsmith.fit(given, "mirror.toml")
    assert said in fit.notes
    since = {**columns, "t_s": [round(t - columns["t_s"][0], 6) for t in columns["t_s"]]}
    assert fit.to_dict()["after"] == arcsmith.fit(since, "mirror.toml").to_dict()["after"]
    with pytest.warns(UserWarning, match="timestamps"):
        diagnosis = arcsmith.diagnose(given, "mirror.toml")
    assert diagnosis.verdict == "consistent" and said in diagnosis.notes


def test_timestamps_of_a_motion_become_seconds_and_it_is_said(run, folder):
    run("excite", "--seed", "7", "--samples", "4096", "--out", "motion.csv")
    plant = {"plant": {"kind": "second-order", "position_unit": "arcsec", "drive_unit": "A"}}
    motion = pandas.read_csv("motion.csv")
    stamps = pandas.Timestamp("2025-03-01 08:00") + pandas.to_timedelta((1e6 * motion["t_s"]).round(), unit="us")
    stamped = motion.assign(t_s=stamps)
    stamped.assign(t_s=stamps.dt.strftime("%Y-%m-%dT%H:%M:%S.%f")).to_csv("stamped.csv", index=False)
    said = "column `t_s` holds timestamps: taken as seconds since its first row"
    in_file = f"{said}, 2025-03-01T08:00:00.000000"
    for given, note in ((stamped, said), ("stamped.csv", in_file)):
        with pytest.warns(UserWarning, match="timestamps"):
            diagnosis = arcsmith.diagnose(given, plant=plant)
        assert diagnosis.notes == [note]
        assert diagnosis.effects == arcsmith.diagnose(motion, plant=plant).effects
        with pytest.warns(UserWarning, match="timestamps"):
            simulated = arcsmith.simulate(given, dict(plant={**plant["plant"], "damping": 32.0, "stiffness": 21000.0, "gain": 3e8}))
        assert simulated.notes == [note] and simulated["t_s"][:2] == [0.0, 0.0005]


def test_blanks_and_text_in_optional_columns(folder, columns):
    count = len(columns["t_s"])
    blank = columns | {"coil_a": [None, *columns["coil_a"][1:]], "operator": ["Kim"] * count}
    note = "column `operator` holds no numbers and is left out"
    for kind in ("lists", "pandas", "polars"):
        assert note in arcsmith.fit(KINDS[kind](blank), "mirror.toml").notes
    nan = columns | {"coil_a": numpy.array([numpy.nan, *columns["coil_a"][1:]])}
    assert arcsmith.fit(nan, "mirror.toml").order == 9


def test_other_names_and_units(folder, columns):
    given = {("Probe 1" if name == "x1_mm" else name): values for name, values in columns.items()}
    given["Probe 1"] = [1000 * value for value in given["Probe 1"]]
    for map in ({"x1_mm": "Probe 1:um"}, ["x1_mm=Probe 1:um"]):
        fit = arcsmith.fit(given, "mirror.toml", map=map)
        assert fit.after_rms == pytest.approx(arcsmith.fit(columns, "mirror.toml").after_rms, rel=1e-9)
        assert "columns taken as x1_mm=Probe 1:um" in fit.notes


def test_the_index_of_pandas_is_no_column(folder, columns):
    frame = pandas.DataFrame(columns)
    odd = frame.set_index(pandas.Index(range(7, 7 + 3 * len(frame), 3)))
    assert arcsmith.fit(odd, "mirror.toml").coefficients.to_json() == arcsmith.fit(frame, "mirror.toml").coefficients.to_json()


def test_words_for_the_direction(folder, columns):
    words = ["forward" if value > 0 else "backward" for value in columns["direction"]]
    fit = arcsmith.fit(polars.DataFrame(columns | {"direction": words}), "mirror.toml")
    assert fit.coefficients.to_json() == arcsmith.fit(columns, "mirror.toml").coefficients.to_json()


def test_a_mirror_as_a_dict(folder, columns):
    mirror = {"geometry": {"probe_distance_mm": 12.0, "initial_gap_mm": 0.3}, "reference": {"accuracy_arcsec": 1.0}}
    assert arcsmith.fit(columns, mirror).to_dict() == arcsmith.fit(columns, "mirror.toml").to_dict()


def test_libraries_take_the_columns(folder, columns):
    applied = arcsmith.apply(columns, arcsmith.fit(columns, "mirror.toml"))
    angles = applied["angle_arcsec"]
    assert polars.DataFrame(applied)["angle_arcsec"].to_list() == angles
    assert pyarrow.table(applied)["angle_arcsec"].to_pylist() == angles
    assert pandas.DataFrame.from_arrow(applied)["angle_arcsec"].to_list() == angles
    assert duckdb.sql("select count(*) from applied").fetchall() == [(210,)]
