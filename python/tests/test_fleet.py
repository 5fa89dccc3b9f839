"""The unit of work of a fleet gives the rows that the program writes."""

import pandas
import pyarrow
import pyarrow.parquet
import pytest

import arcsmith
import arcsmith.fleet

OF_THE_FILE = ["file"]


@pytest.fixture(scope="module")
def stacked(run):
    frames = []
    for seed in range(3):
        run("record", "--protocol", "calibration", "--seed", str(seed), "--out", f"unit{seed}.csv")
        frames.append(pandas.read_csv(run.folder / f"unit{seed}.csv").assign(serial=f"u{seed}", batch="b1"))
    frames[1].loc[0, "x1_mm"] = float("nan")
    table = pandas.concat(frames, ignore_index=True)
    table.to_parquet(run.folder / "fleet.parquet")
    words = ("--unit", "serial", "--lot", "batch", "--mirror", "mirror.toml", "--out", "results")
    run("fleet", "fleet.parquet", *words)
    return table


@pytest.mark.parametrize("table", ["units", "parameters"])
def test_rows_are_those_of_the_program(stacked, folder, table):
    rows = arcsmith.fleet.diagnose_batch(stacked, unit="serial", lot="batch", mirror="mirror.toml", table=table)
    own = pyarrow.table(rows)
    program = pyarrow.parquet.read_table(folder / "results" / table)
    assert own.column_names == program.column_names == rows.columns
    assert len(rows) == own.num_rows and own.num_rows == (3 if table == "units" else own.num_rows)
    drop = [name for name in OF_THE_FILE if name in own.column_names]
    assert own.drop_columns(drop).to_pylist() == program.drop_columns(drop).to_pylist()


def test_groups_one_by_one_are_the_same(stacked, folder):
    whole = pyarrow.table(arcsmith.fleet.diagnose_batch(stacked, unit="serial", mirror="mirror.toml"))
    groups = [group for _, group in stacked.groupby("serial")]
    parts = [pyarrow.table(arcsmith.fleet.diagnose_batch(part, unit="serial", mirror="mirror.toml")) for part in groups]
    assert pyarrow.concat_tables(parts).to_pylist() == whole.to_pylist()


def test_a_unit_that_fails_is_a_row(stacked, folder):
    rows = arcsmith.fleet.diagnose_batch(stacked.drop(columns="pass"), unit="serial", mirror="mirror.toml")
    errors = pyarrow.table(rows)["error"].to_pylist()
    assert len(errors) == 3 and all("`pass`" in error for error in errors)


def test_what_is_no_batch_is_refused(stacked, folder):
    def refused(what, batch=stacked, **options):
        with pytest.raises(arcsmith.ArcsmithError, match=what):
            arcsmith.fleet.diagnose_batch(batch, **{"unit": "serial", "mirror": "mirror.toml", **options})

    refused("no column `nothing`", unit="nothing")
    refused("a batch is a table", batch="fleet.parquet")
    refused("expected \"units\" or \"parameters\"", table="all")
    refused("names no unit", batch=stacked.assign(serial=None))
