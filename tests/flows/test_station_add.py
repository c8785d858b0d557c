"""Stations of a home without a Prefect server: their files, and what is refused."""

from pathlib import Path

import pytest

from tasks.station.virtual.config import VirtualStation, station_file


@pytest.fixture
def given(tmp_path: Path) -> Path:
    return written(tmp_path / "given.json", "S-1")


def written(path: Path, station: str) -> Path:
    file = station_file(VirtualStation(), 1.0, "127.0.0.1", 1, 2)
    named = file.station.model_copy(update={"id": station})
    path.write_text(file.model_copy(update={"station": named}).model_dump_json(), "utf-8")
    return path


def test_a_station_is_kept_under_its_id_for_its_owner_alone_and_goes_again(
    mimucal, home, given
) -> None:
    for _ in range(2):
        added = mimucal("station", "add", given)
        assert added.code == 0, added.err
    (kept,) = (home / "stations").iterdir()
    assert (kept.name, kept.stat().st_mode & 0o777) == ("S-1.json", 0o600)
    assert kept.read_bytes() == given.read_bytes()
    assert mimucal("station", "remove", "S-1").code == 0
    assert not list((home / "stations").iterdir())
    assert mimucal("station", "remove", "S-1").code == 2


def test_what_was_kept_under_another_name_is_replaced(mimucal, home, given) -> None:
    (home / "stations").mkdir(parents=True)
    written(home / "stations/old.json", "S-1")
    assert mimucal("station", "add", given).code == 0
    assert [path.name for path in (home / "stations").iterdir()] == ["S-1.json"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--schedule", "0 8 * * *"), "PREFECT_API_URL"),
        (("--timezone", "Mars/Base"), "--timezone Mars/Base"),
    ],
)
def test_what_cannot_be_done_is_refused_and_nothing_is_kept(
    mimucal, home, given, options, sentence
) -> None:
    refused = mimucal("station", "add", given, *options)
    assert refused.code == 2
    assert sentence in refused.err
    assert not home.exists()


def test_deploying_without_a_server_says_what_is_missing(mimucal, home) -> None:
    refused = mimucal("deploy")
    assert refused.code == 2
    assert "PREFECT_API_URL" in refused.err
