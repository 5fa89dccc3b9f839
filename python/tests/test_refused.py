"""What is refused, and with which message: that of the program."""

import arcsmith
import numpy
import pandas
import polars
import pyarrow
import pytest


def message(*given, **options):
    with pytest.raises(arcsmith.ArcsmithError) as refused:
        arcsmith.fit(*given, **options)
    return str(refused.value)


def told(run, *words):
    return run(*words)["error"]["message"]


def test_missing_columns_as_the_program_says_it(run, folder, columns):
    lines = (folder / "calibration.csv").read_text().replace("x2_mm", "x3_mm")
    (folder / "wrong.csv").write_text(lines)
    program = told(run, "fit", "wrong.csv", "--mirror", "mirror.toml")
    given = {("x3_mm" if name == "x2_mm" else name): values for name, values in columns.items()}
    assert message("wrong.csv", "mirror.toml") == program
    # A table has no line in which its header stands.
    assert message(pandas.DataFrame(given), "mirror.toml", name="wrong.csv") == program.replace("wrong.csv, line 1:", "wrong.csv:")
    assert "column `x2_mm` is missing" in program and "rename `x3_mm`" in program


def test_a_bad_cell_as_the_program_says_it(run, folder, columns):
    whole = columns | {"pass": [1.5, *columns["pass"][1:]]}
    pandas.DataFrame(whole).to_csv(folder / "wrong.csv", index=False)
    program = told(run, "fit", "wrong.csv", "--mirror", "mirror.toml")
    assert message(polars.DataFrame(whole), "mirror.toml", name="wrong.csv") == program
    assert program.startswith("wrong.csv, line 2, column `pass`: found `1.5`, expected a whole number")


def test_nulls(folder, columns):
    null = columns | {"x1_mm": [*columns["x1_mm"][:4], None, *columns["x1_mm"][5:]]}
    expected = "table, row 5, column `x1_mm`: is null, expected a number (only optional columns may have nulls); drop the row"
    for given in (null, polars.DataFrame(null), pyarrow.table(null), pandas.DataFrame(null)):
        assert message(given, "mirror.toml") == expected


def test_nan(folder, columns):
    nan = columns | {"x1_mm": numpy.array([numpy.nan, *columns["x1_mm"][1:]])}
    assert message(nan, "mirror.toml").startswith("table, row 1, column `x1_mm`: found `NaN`, expected a finite number")
    infinite = columns | {"t_s": [float("inf"), *columns["t_s"][1:]]}
    assert message(infinite, "mirror.toml").startswith("table, row 1, column `t_s`: found `inf`, expected a finite number")


def test_nested_columns(folder, columns):
    count = len(columns["t_s"])
    lists = polars.DataFrame(columns | {"x1_mm": [[1.0, 2.0]] * count})
    assert message(lists, "mirror.toml").startswith("table, column `x1_mm`: is nested (a list), expected plain columns")
    groups = pyarrow.table(columns | {"more": [{"a": 1}] * count})
    assert "column `more`: is nested (a group of fields)" in message(groups, "mirror.toml")
    assert "is nested" in message(columns | {"x1_mm": numpy.ones((count, 2))}, "mirror.toml")
    assert "is nested" in message(columns | {"x1_mm": [[1.0]] * count}, "mirror.toml")


def test_text_in_a_needed_column(folder, columns):
    text = columns | {"x2_mm": ["off"] * len(columns["t_s"])}
    for given in (text, pandas.DataFrame(text), polars.DataFrame(text)):
        assert message(given, "mirror.toml").startswith("table, row 1, column `x2_mm`: found `off`, expected a number")


def test_unequal_lengths(folder, columns):
    short = columns | {"x2_mm": columns["x2_mm"][:-1]}
    expected = "table, column `x2_mm`: found 209 values, expected 210 as in column `t_s`; give every column one value for each row"
    assert message(short, "mirror.toml") == expected


def test_no_rows_and_no_columns(folder, columns):
    assert "has a header but no reading" in message(pandas.DataFrame(columns).iloc[:0], "mirror.toml")
    assert "are missing" in message({}, "mirror.toml")


def test_what_is_no_recording(folder, columns):
    for other in (3, None, object()):
        assert message(other, "mirror.toml").startswith("is no recording: ") or "is no recording" in message(other, "mirror.toml")
    assert "a list or an array" in message(columns | {"x1_mm": 3.0}, "mirror.toml")
    assert "is no text" in message({1: [2.0]}, "mirror.toml")


def test_parts_of_the_message(folder, columns):
    with pytest.raises(ValueError) as refused:
        arcsmith.fit(columns | {"x1_mm": [None] * len(columns["t_s"])}, "mirror.toml")
    assert isinstance(refused.value, arcsmith.ArcsmithError)
    parts = refused.value.parts
    assert (parts["file"], parts["line"], parts["column"]) == ("table", 1, "x1_mm") and parts["mend"] == "drop the row"


def test_options(run, folder, columns):
    assert "no such solver" in message(columns, "mirror.toml", solver="magic")
    assert "order" in message(columns, "mirror.toml", order=40)
    assert "did you mean `geometry`?" in message(columns, {"geometri": {}})
    none = {"geometry": {"probe_distance_mm": None}}
    assert message(columns, none) == "mirror.toml: holds None, which says nothing; leave the key out"
    assert message("nowhere.csv", "mirror.toml") == told(run, "fit", "nowhere.csv", "--mirror", "mirror.toml")
    fit = arcsmith.fit(columns, "mirror.toml")
    for options, expected in [
        ({"frmat": "q31"}, "--frmat"),
        ({"format": "q99"}, "q99"),
        ({"out": "x"}, "no keyword"),
        ({"format": "f32", "fma": True, "target": "cortex-m3"}, "cortex-m3 has no fused multiply-add"),
        ({"bound_arcsec": 1e-12}, "arcsec"),
    ]:
        with pytest.raises(arcsmith.ArcsmithError, match=expected):
            arcsmith.generate(fit, **options)
    with pytest.raises(arcsmith.ArcsmithError, match="one of the two"):
        arcsmith.diagnose(columns)
    with pytest.raises(arcsmith.ArcsmithError, match="held-out table: columns `pass`, "):
        arcsmith.diagnose(columns, "mirror.toml", held_out={"t_s": [1.0]})
    with pytest.raises(arcsmith.ArcsmithError, match="simulation table"):
        arcsmith.diagnose(columns, "mirror.toml", simulated={"t_s": [1.0], "reference_arcsec": [1.0]})
    with pytest.raises(arcsmith.ArcsmithError, match="no effect of the catalogue"):
        arcsmith.diagnose(columns, "mirror.toml", without=["gremlins"])
    with pytest.raises(arcsmith.ArcsmithError, match="is missing, which"):
        bare = {name: columns[name] for name in ("t_s", "pass", "x1_mm", "x2_mm")}
        arcsmith.apply(bare, arcsmith.diagnose("warm.csv", "mirror.toml"), strict=True)
