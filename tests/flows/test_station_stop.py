"""`mimucal station stop`, and what `station status` says of a run that was killed."""

import json

import pytest

from storage.home import Home
from storage.station_lock import write_status
from tests.storage.test_stations import status
from tests.tasks.station.sample_stations import sample


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
