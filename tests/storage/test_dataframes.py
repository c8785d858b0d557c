"""The store as DataFrames: one row for each thing, columns even where there is nothing."""

import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import sqlalchemy as sql

from storage import dataframes
from storage.catalogue import database, results, runs, tables
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003
from tests.keep import keep
from tests.storage.small import calibrated, certified, small


def test_each_run_is_a_row(fresh):
    kept = [runs.add(small(start), fresh)[0] for start in (0.0, 1.0)]
    table = dataframes.runs(fresh)
    assert list(table["id"]) == [run.id for run in kept]
    assert list(table["rows"]) == [300, 300]


def test_each_element_of_each_result_is_a_row_and_the_newest_are_marked(fresh):
    run = runs.add(small(), fresh)[0]
    first, second = (results.save(calibrated(run, value), fresh) for value in (0.25, 0.5))
    table = dataframes.results(fresh).set_index("result")
    assert list(table.index.unique()) == [first, second]
    assert not table.loc[[first], "newest"].any()
    assert table.loc[[second], "newest"].all()
    assert set(table["serial"]) == {"1"}
    assert set(table.loc[[second], "value"].dropna()) == {0.5}


def test_segments_and_budgets_of_a_calibration(fresh, ideal_run):
    recording = ideal_run(dwell=1.0)
    run = runs.add(recording, fresh)[0]
    calibration = calibrate(JJF2003, runs.load(run, fresh), run=run.id, code_version="v")
    results.save(calibration, fresh)
    used = dataframes.segments(fresh)
    assert list(used["name"]) == [segment.name for segment in calibration.segments]
    assert set(used["recording_id"]) == {"ideal"}
    first = recording.imu.rows(used["t_start"][0], used["t_end"][0])
    for name in ("gyro_x", "accel_z"):
        values = recording.imu.columns[name][first]
        assert used[f"mean_{name}"][0] == pytest.approx(values.mean(), rel=1e-12)
        assert used[f"deviation_{name}"][0] == pytest.approx(values.std(), rel=1e-6)
    budgets = dataframes.budgets(calibration)
    for (name, element), lines in budgets.groupby(["item", "element"]):
        budget = calibration.items[str(name)].budgets[str(element)]
        assert len(lines) == len(budget.inputs)
        np.testing.assert_allclose(lines["u_c"], budget.u_c)


def test_tables_open_no_document_and_no_recording(fresh):
    run = runs.add(small(), fresh)[0]
    results.save(calibrated(run), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.results).values(document="no JSON"))
    shutil.rmtree(fresh.raw)
    shutil.rmtree(fresh.columns)
    assert list(dataframes.results(fresh)["value"].dropna()) == [0.25]
    assert list(dataframes.runs(fresh)["station"]) == ["T1"]


def test_results_of_an_earlier_version_are_in_the_tables(fresh, ideal_run):
    recording = ideal_run(dwell=1.0)
    run = runs.add(recording, fresh)[0]
    results.save(calibrate(JJF2003, runs.load(run, fresh), run=run.id, code_version="v"), fresh)
    expected = [dataframes.results(fresh), dataframes.segments(fresh)]
    with database.changing(fresh) as connection:
        for table in (tables.elements, tables.segments, tables.outcomes):
            connection.execute(sql.delete(table))
    for table, before in zip((dataframes.results, dataframes.segments), expected, strict=True):
        pd.testing.assert_frame_equal(table(fresh), before)


def test_each_certificate_is_a_row_with_its_run(fresh):
    recording = small()
    run = runs.add(recording, fresh)[0]
    keep(certified(recording, calibrated(run), "A-1"), fresh)
    (row,) = dataframes.certificates(fresh).to_dict("records")
    assert (row["number"], row["run"], row["serial"], row["verdict"]) == (
        "A-1", run.id, "1", "pass",
    )  # fmt: skip


def test_an_empty_home_gives_empty_tables_with_their_columns(fresh):
    for ask in dataframes.TABLES.values():
        table = ask(fresh)
        assert table.empty
        assert len(table.columns) > 5
    assert not fresh.path.exists()


def test_pandas_is_imported_when_a_table_is_asked_for():
    code = "import sys; from storage import dataframes; print('pandas' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
