"""`mimucal station load`: the coefficients of a result on their way into the unit."""

import json
from pathlib import Path
from typing import Any

import pytest

from tasks.station import load_coefficients
from tests.tasks.station.over_sockets import unit
from tests.tasks.station.sample_stations import sample

LINES = ["$WRITE,10,{B_g[0]:+.6e}", "$WRITE,11,{C_a[1][2]:+.6e}"]
pytestmark = pytest.mark.real_time


@pytest.fixture
def correction(mimucal, run_on_earth) -> dict[str, Any]:
    return json.loads(mimucal("export", run_on_earth, "--as", "json").out)


def station_file(folder: Path, correction: dict[str, Any], url: str, **unit: str) -> Path:
    """Of the calibrated unit, at an address that takes LINES."""
    fields = sample()
    load = {"lines": LINES, "acknowledge": "$OK"}
    fields["unit_link"] |= {"url": url, "load": load}
    fields["unit"] |= correction["unit"] | unit
    file = folder / "station.json"
    file.write_text(json.dumps(fields), encoding="utf-8")
    return file


def test_the_unit_is_told_the_coefficients_of_its_own_result(mimucal, correction, tmp_path):
    with unit(lambda _: b"$OK\r\n") as (url, document):
        file = station_file(tmp_path, correction, url)
        done = mimucal("station", "load", file, correction["run"])
    assert (done.code, done.err) == (0, "")
    assert done.out.strip().endswith("acknowledged 2 lines")
    bias, gain = (correction["coefficients"][name]["value"] for name in ("B_g", "C_a"))
    assert [float(line.decode().split(",")[-1]) for line in document] == pytest.approx(
        [bias[0], gain[1][2]], rel=1e-6
    )


def test_what_was_loaded_is_said_as_json(mimucal, correction, tmp_path):
    with unit(lambda _: b"$OK\r\n") as (url, _):
        file = station_file(tmp_path, correction, url)
        loaded = mimucal("station", "load", file, correction["run"], "--json").json
    assert (loaded["format"], loaded["lines"]) == ("mimu-station-load/1", 2)
    assert loaded["unit"]["serial"] == correction["unit"]["serial"]


@pytest.mark.parametrize(
    ("changes", "answer", "sentence"),
    [
        ({"serial": "other"}, b"$OK", "give the result of that unit"),
        ({}, b"$ERR", "did not acknowledge"),
    ],
)
def test_what_cannot_be_loaded_is_one_sentence(
    mimucal, correction, tmp_path, monkeypatch, changes, answer, sentence
):
    monkeypatch.setattr(load_coefficients, "ANSWER_S", 0.3)
    with unit(lambda _: answer) as (url, _):
        file = station_file(tmp_path, correction, url, **changes)
        done = mimucal("station", "load", file, correction["run"])
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1)
    assert sentence in done.err
