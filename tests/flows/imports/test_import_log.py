"""A stranger's logger file: to values in two commands, and one true sentence for each mistake."""

from functools import partial
from importlib.metadata import version

import numpy as np
import pytest

from tests.storage.formats.logger.makers.loggers import (
    LOGGERS,
    bosch,
    phyphox,
    protocol,
    workbook,
)
from tests.tasks.readings.makers import mistakes
from tests.tasks.readings.makers.bench import G, bench

RUN = {"dwell": 6.0, "rates": (40.0, 120.0)}
SCALE = {"gyro_scale_factor": "gyro_scale", "accel_scale_factor": "accel_scale"}
GRAVITY = ("--gravity", str(G))
SWAPPED = np.eye(3)[[1, 0, 2]]
Z = np.diag([1.0, 1.0, -1.0])


# That each is read as it was written, tests/storage/formats/logger says.
@pytest.mark.parametrize(
    "write",
    [
        pytest.param(one, marks=[] if one in (bosch, workbook) else pytest.mark.rehearsal)
        for one in LOGGERS
    ],
    ids=lambda one: one.__name__,
)
def test_ten_loggers_files_come_to_values_in_two_commands(mimucal, tmp_path, write):
    made = bench(LOGGERS.index(write), **RUN)
    log, lines = write(made, tmp_path)
    held = ("--commanded-rate", "1e-4")  # without it K has no U: nobody states its largest error
    taken = mimucal("import", log, "--protocol", lines, *GRAVITY, *held, "--yes", "--json")
    assert taken.code == 0
    (entry,) = taken.json["runs"]
    assert entry["new"]
    assert entry["understood"]["doubts"] == []
    items = mimucal("calibrate", entry["run"], "--json").json["items"]
    for item, truth in SCALE.items():
        for k, axis in enumerate("xyz"):
            off = items[item]["value"][axis] - made.truth[truth][k, k]
            assert abs(off) < 1.5 * items[item]["U"][axis], (item, axis)


MISTAKES = {
    "unit": (partial(mistakes.gyro_times, factor=np.pi / 180), "look like rad/s"),
    "exchanged": (partial(mistakes.both_mapped, matrix=SWAPPED), "x, y are exchanged"),
    "inverted": (partial(mistakes.gyro_mapped, matrix=Z), "gyro z inverted"),
    "late 0.5 s": (partial(mistakes.labels_late, seconds=0.5), "0.50 s (± "),
    "late 10 s": (partial(mistakes.labels_late, seconds=10.0), "--shift -10.0"),
    "no gravity": (mistakes.gravity_removed, "gravity was removed"),
}


# What finds each of them is judged in tests/tasks/readings.
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(one, marks=[pytest.mark.rehearsal] if number not in (0, 5) else [])
        for number, one in enumerate(MISTAKES)
    ],
)
def test_each_mistake_gets_one_true_sentence(mimucal, tmp_path, name):
    make, part = MISTAKES[name]
    made = bench(31, **RUN)
    make(made)
    log, lines = bosch(made, tmp_path)
    (entry,) = mimucal(
        "import", log, "--protocol", lines, *GRAVITY, "--units", "accel=mg", "--yes", "--json"
    ).json["runs"]
    (doubt,) = entry["understood"]["doubts"]
    assert part in doubt or abs(float(doubt.split(" s (")[0].split()[-1]) - 0.5) < 0.1
    shown = mimucal("calibrate", entry["run"], "--json").json
    assert shown["validity"]["verdict"] == "invalid"
    assert shown["validity"]["reasons"][0].split(":")[0] == doubt.split(":")[0]


@pytest.mark.rehearsal
def test_half_of_the_positions_missing_is_one_sentence(mimucal, tmp_path):
    made = bench(32, **RUN)
    made.labels = [one for one in made.labels if not str(one.get("up")).startswith("-")]
    log, lines = phyphox(made, tmp_path)
    (entry,) = mimucal("import", log, "--protocol", lines, *GRAVITY, "--yes", "--json").json["runs"]
    about = [note for note in entry["understood"]["notes"] if "positions" in note]
    assert about == [
        "3 of the six positions are missing (no rest has -x, -y, -z up): scale factor and bias of "
        "an accelerometer need its axis both up and down"
    ]


def test_nothing_is_kept_before_it_is_confirmed(mimucal, tmp_path, home):
    log, lines = phyphox(bench(33, **RUN), tmp_path)
    done = mimucal("import", log, "--protocol", lines)
    assert done.code == 0
    assert "gyro_x" in done.out
    assert "picture: " in done.out
    assert "--yes" in done.err
    assert not list(home.rglob("*.mcap"))
    assert list(home.rglob("*.svg"))


def test_the_next_file_is_read_like_the_last(mimucal, tmp_path):
    made = bench(34, **RUN)
    names = "a,b,c,d,e,f,g"
    values = np.column_stack([1e3 * made.t, np.degrees(made.gyro), made.accel])
    lines = protocol(made, tmp_path / "protocol.csv")
    for name in ("first", "next"):
        np.savetxt(tmp_path / f"{name}.csv", values, delimiter=",", header=names, comments="")
    refused = mimucal("import", tmp_path / "first.csv", "--protocol", lines, "--yes")
    assert refused.code == 2
    assert refused.err.count("?") == 1
    columns = "t=a,gyro_x=b,gyro_y=c,gyro_z=d,accel_x=e,accel_y=f,accel_z=g"
    (first,) = mimucal(
        "import", tmp_path / "first.csv", "--protocol", lines, "--columns", columns,
        "--units", "t=ms,gyro=deg/s,accel=m/s2", *GRAVITY, "--yes", "--json",
    ).json["runs"]  # fmt: skip
    (later,) = mimucal(
        "import", tmp_path / "next.csv", "--protocol", lines, "--like", first["run"], "--yes",
        "--json",
    ).json["runs"]  # fmt: skip
    assert later["understood"]["columns"] == {
        name: {**one, "known_by": "--units"} for name, one in first["understood"]["columns"].items()
    }
    assert later["understood"]["gravity_m_s2"] == G


def test_without_a_protocol_rests_are_found_and_rates_are_proposals(mimucal, tmp_path):
    log, _ = phyphox(bench(35, **RUN), tmp_path)
    (entry,) = mimucal("import", log, *GRAVITY, "--yes", "--json").json["runs"]
    found = entry["understood"]["segments"]
    rates = sorted(one["rate_deg_s"] for one in found if one["kind"] == "rate")
    assert rates == [-120.0] * 3 + [-40.0] * 3 + [40.0] * 3 + [120.0] * 3
    assert sum(one["kind"] == "static" for one in found) >= 12
    shown = mimucal("calibrate", entry["run"], "--json").json
    assert shown["items"]["gyro_scale_factor"]["value"]["x"] is None
    assert abs(shown["items"]["accel_scale_factor"]["value"]["x"] - 1.0) < 0.05


def test_a_table_is_no_recording_of_other_commands(mimucal, tmp_path):
    log, _ = phyphox(bench(36, **RUN), tmp_path)
    done = mimucal("calibrate", log)
    assert done.code == 2
    assert "mimucal import" in done.err


def test_version_names_program_release_and_digest(mimucal):
    done = mimucal("--version")
    assert done.code == 0
    assert done.out.startswith(f"mimucal {version('mimucal')}+")


@pytest.mark.rehearsal
def test_the_right_unit_is_that_of_the_file_however_often_it_is_said(mimucal, tmp_path):
    """What is kept is in rad/s already: a way out for the file must not be one for that."""
    made = bench(31, **RUN)
    mistakes.gyro_times(made, factor=np.pi / 180)
    log, lines = bosch(made, tmp_path)
    (entry,) = mimucal(
        "import", log, "--protocol", lines, *GRAVITY, "--units", "accel=mg", "--yes", "--json"
    ).json["runs"]
    first = mimucal("show", entry["run"], "--json").json["validity"]["reasons"][0]
    assert [first] == entry["understood"]["doubts"]
    assert "--units gyro=rad/s," in first
