"""The store as tables that other programs read."""

import shutil
from io import StringIO

import duckdb
import pandas as pd
import pyarrow.dataset as ds
import pytest

from schemas.calibration import BudgetInput
from schemas.history import Change
from schemas.orders import CalibrateOrder
from storage import dataframes
from storage.catalogue import runs
from storage.home import Home
from tasks.stages.estimate import estimate


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory, ideal_run) -> Home:
    """A run, calibrated."""
    kept = Home(tmp_path_factory.mktemp("calibrated") / "home")
    run, _ = runs.add(ideal_run(dwell=1.0), kept)
    estimate(run, kept, CalibrateOrder(run=run.id))
    return kept


@pytest.fixture
def store(home, calibrated) -> Home:
    """A copy of it, where commands look."""
    shutil.copytree(calibrated.path, home)
    return Home(home)


@pytest.mark.parametrize("what", ["runs", "results", "segments"])
def test_csv_on_standard_output_holds_the_table(store, mimucal, what):
    printed = pd.read_csv(StringIO(mimucal("table", what).out))
    expected = dataframes.TABLES[what](store)
    assert list(printed.columns) == list(expected.columns)
    assert len(printed) == len(expected) > 0


def test_parquet_keeps_every_digit(store, mimucal, tmp_path):
    file = tmp_path / "results.parquet"
    assert mimucal("table", "results", "--as", "parquet", "--out", file).code == 0
    pd.testing.assert_series_equal(
        pd.read_parquet(file)["value"], dataframes.results(store)["value"]
    )


def test_a_folder_is_partitioned_by_station_and_month(store, mimucal, tmp_path):
    folder = tmp_path / "segments"
    assert mimucal("table", "segments", "--as", "parquet", "--out", folder).code == 0
    assert [each.name for each in (folder / "station=test").iterdir()] == ["month=unknown"]
    read = ds.dataset(folder, partitioning="hive").to_table(filter=ds.field("station") == "test")
    assert read.num_rows == len(dataframes.segments(store))
    assert mimucal("table", "segments", "--as", "parquet", "--out", folder).code == 2


def test_duckdb_reads_each_column_by_its_name(store, mimucal, tmp_path):
    mimucal("table", "results", "--as", "parquet", "--out", tmp_path / "results.parquet")
    mimucal("table", "results", "--out", tmp_path / "results.csv")
    expected = dataframes.results(store)
    for file in ("results.parquet", "results.csv"):
        for name in ("standard_uncertainty", "expanded_uncertainty", "k"):
            asked = f"SELECT {name.upper()} FROM '{tmp_path / file}'"
            found = pd.Series([row[0] for row in duckdb.sql(asked).fetchall()], dtype=float)
            pd.testing.assert_series_equal(found, expected[name], check_names=False)


@pytest.mark.parametrize("what", dataframes.TABLES)
def test_columns_of_a_table_differ_by_more_than_case(store, what):
    names = [name.lower() for name in dataframes.TABLES[what](store).columns]
    assert len(set(names)) == len(names)


def test_columns_of_the_other_files_differ_by_more_than_case():
    for names in (list(Change.model_fields), ["item", "element", "u_c", *BudgetInput.model_fields]):
        assert len({name.lower() for name in names}) == len(names)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [(("raw",), "'raw'"), (("runs", "--as", "xlsx"), "--as xlsx"),
     (("runs", "--out", "/dev/null/x.csv"), "/dev/null/x.csv")],
)  # fmt: skip
def test_what_cannot_be_is_one_sentence(store, mimucal, arguments, named):
    refused = mimucal("table", *arguments)
    assert refused.code == 2
    assert named in refused.err


@pytest.mark.parametrize("what", ["runs", "results", "segments", "certificates"])
def test_json_holds_the_rows_of_the_table(store, mimucal, what):
    document = mimucal("table", what, "--json").json
    expected = dataframes.TABLES[what](store)
    assert (document["format"], document["table"]) == ("mimu-table/1", what)
    assert len(document["rows"]) == len(expected)
    for row, (_, other) in zip(document["rows"], expected.iterrows(), strict=True):
        assert list(row) == list(expected.columns)
        numbers = {name: value for name, value in row.items() if isinstance(value, float)}
        assert numbers == {name: other[name] for name in numbers}
