"""`mimucal show RUN --log`."""

import json

import pytest

ENTRY = {"at": "2026-03-01T08:00:00Z", "t": 1.5, "state": "paused", "en": "A rest.", "zh": "暂停。"}


@pytest.fixture
def with_log(copied):
    """A recording whose manifest keeps this log."""

    def write(log):
        folder = copied("real/ferraris_session")
        path = folder / "manifest.json"
        manifest = json.loads(path.read_text(encoding="utf-8"))
        path.write_text(json.dumps(manifest | {"log": log}), encoding="utf-8")
        return folder

    return write


def test_the_log_comes_back_as_it_was_kept(mimucal, with_log):
    folder = with_log([ENTRY])
    document = mimucal("show", folder, "--log", "--json").json
    assert document["format"] == "mimu-run-log/1"
    assert document["log"] == [ENTRY]
    printed = mimucal("show", folder, "--log").out
    assert "2026-03-01 08:00:00" in printed
    assert "A rest." in printed


def test_a_run_without_a_log_says_so(mimucal, shared):
    done = mimucal("show", shared / "real/ferraris_session", "--log")
    assert done.code == 2
    assert "has no log" in done.err


@pytest.mark.parametrize("log", ["text", [{"at": "yesterday"}], {"state": "paused"}])
def test_a_log_of_others_that_is_not_understood_is_refused(mimucal, with_log, log):
    done = mimucal("show", with_log(log), "--log")
    assert done.code == 2
    assert "is not understood" in done.err
    assert done.err.count("\n") == 1
