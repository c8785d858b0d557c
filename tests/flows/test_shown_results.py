"""`mimucal show RUN --log`."""

import json

import pytest

from flows.shown_results import print_calibration
from schemas.calibration import Information
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003

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


# What `mimucal calibrate` prints for a person.


def test_information_is_a_second_table_with_its_sentences(
    ideal_run, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = {
        "noise": Information(
            title="Angle random walk", title_zh="随机游走", unit="deg/sqrt(h)",
            value={"x": 0.08433}, U={"x": 0.00134}, en="From [18] rests.", zh="静止数据。",
        ),
        "floor": Information(
            title="Bias instability", title_zh="零偏不稳定性", unit="deg/h",
            value={"x": None}, en="No floor.", zh="未见最小值。",
        ),
    }  # fmt: skip
    made = calibrate(JJF2003, ideal_run(), run="r", code_version="v")
    print_calibration(made.model_copy(update={"information": shown}))
    first, second = capsys.readouterr().out.split("for information, not decided on")
    assert "Gyro scale factor" in first
    row = next(line for line in second.splitlines() if "│ Angle random walk" in line)
    assert [cell.strip() for cell in row.split("│")[2:7]] == ["x", "0.0843", "0.0014", "2", "°/√h"]
    assert "From [18] rests." in second
    assert "│ Bias instability" not in second
    assert "· Bias instability: No floor." in second
