"""`acquire --dry-run` on a station that nobody answers for: nothing is connected, nothing moves."""

import json
from pathlib import Path

import pytest

from flows import station_commands as commands
from schemas.laboratory import Limits
from storage.home import Home
from storage.stations import write_status
from tasks.station.virtual.config import VirtualStation, station_file
from tests.storage.test_stations import status
from tests.tasks.station.sample_stations import sample

SEGMENTS = 48  # 12 positions, 3 × 2 rests and 3 × 10 rates


@pytest.fixture
def station(tmp_path):
    """Writes the file of a station with these limits; its path."""

    def write(limits):
        file = station_file(VirtualStation(), 1.0, "127.0.0.1", 1, 1)
        path = tmp_path / "station.json"
        path.write_text(
            file.model_copy(update={"limits": Limits.model_validate(limits)}).model_dump_json()
        )
        return path

    return write


def test_every_segment_comes_with_its_beginning_and_its_motion(mimucal, station, home):
    done = mimucal("acquire", station({}), "--dry-run", "--json")
    assert done.code == 0
    assert done.json["format"] == "mimu-dry-run/1"
    segments = done.json["segments"]
    assert len({segment["segment"] for segment in segments}) == len(segments) == SEGMENTS
    first, *_, last = segments
    assert first["begins_s"] == 600.0  # the warm-up
    assert len(first["angles_deg"]) == 3
    assert first["rate_deg_s"] == 0.0
    assert {segment["rate_deg_s"] for segment in segments} >= {-200.0, 200.0}
    ends = [segment["begins_s"] + segment["takes_s"] for segment in segments]
    begins = [segment["begins_s"] for segment in segments]
    assert begins[1:] == pytest.approx(ends[:-1], abs=0.15)
    assert done.json["station_s"] == pytest.approx(last["begins_s"] + last["takes_s"], abs=0.15)
    assert not home.exists()


def test_a_person_reads_a_row_for_each_segment(mimucal, station):
    done = mimucal("acquire", station({}), "--dry-run")
    assert done.code == 0
    title, *rows = done.out.splitlines()
    assert title.startswith("JJF 2003")
    assert sum("rate_x_" in row for row in rows) > 1
    assert any("position_+x_000" in row for row in rows)


def test_what_the_table_must_not_do_is_said_before_anything_is_connected(mimucal, station):
    done = mimucal("acquire", station({"axes": {"outer": {"rate_deg_s": 5.0}}}), "--dry-run")
    assert done.code == 2
    assert "limit 5" in done.err
    assert done.out == ""


# `mimucal station stop`, and what `station status` says of a run that was killed.


@pytest.mark.real_time
def test_where_rest_is_not_confirmed_it_fails_and_names_the_emergency_stop(tmp_path, mimucal):
    fields = sample("mimucal")
    fields["table"]["url"] = "socket://127.0.0.1:1"
    file = tmp_path / "station.json"
    file.write_text(json.dumps(fields), encoding="utf-8")
    stopped = mimucal("station", "stop", file, "--by", "Li")
    assert stopped.code == 1
    assert "use the emergency stop" in stopped.err


def test_a_station_that_nobody_knows_is_one_sentence(mimucal):
    stopped = mimucal("station", "stop", "T9")
    assert stopped.code == 2
    assert "station T9" in stopped.err


def test_of_a_run_that_was_killed_nothing_says_that_it_goes_on(home, mimucal):
    write_status(status("measuring"), Home(home))
    (run,) = mimucal("station", "status", "--json").json["runs"]
    assert (run["state"], run["is_dead"]) == ("stopped", False)
    assert "ended without a word" in run["cause"]


# `mimucal station check` on a station that nobody answers for.


@pytest.mark.real_time
def test_every_device_that_does_not_work_is_said_and_the_command_fails(
    tmp_path, monkeypatch, capsys
):
    import typer

    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "home"))
    fields = sample("mimucal")
    for device in ("table", "chamber", "fixture", "unit_link"):
        fields[device]["url"] = "socket://127.0.0.1:1"
    file = Path(tmp_path / "station.json")
    file.write_text(json.dumps(fields), encoding="utf-8")
    with pytest.raises(typer.Exit) as end:
        commands.check(str(file), move=False, as_json=True)
    assert end.value.exit_code == 1
    checked = json.loads(capsys.readouterr().out)
    assert checked["format"] == "mimu-station-check/1"
    failed = {(trial["device"], trial["works"]) for trial in checked["trials"]}
    assert failed == {(name, False) for name in ("table", "chamber", "fixture", "unit")}
