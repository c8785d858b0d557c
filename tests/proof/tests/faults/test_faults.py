"""Runs with a fault, as `make prove ARGS="--faults N"` holds them, on a procedure that is brief."""

from dataclasses import replace

import pytest

from schemas.recording import Recording, Stream
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tests.proof.faults import judge, run
from tests.proof.faults.hold import drawn


@pytest.fixture(autouse=True)
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "DWELL_S", 3.0)


@pytest.fixture(scope="module")
def sound() -> run.Outcome:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "DWELL_S", 3.0)
        return run.run_with(None, VirtualStation())


def recording_of(outcome: run.Outcome) -> Recording:
    assert outcome.recording is not None
    return outcome.recording


@pytest.mark.parametrize("name", ["emergency_stop", "encoder_scale", "unit_merges"])
def test_a_run_with_a_fault_ends_as_it_should(name: str, sound: run.Outcome) -> None:
    outcome = run.run_with(StationFault(name, 40.0), VirtualStation())
    assert judge.violations(name, outcome, recording_of(sound)) == []


def test_values_that_are_wrong_in_a_run_that_stands_are_seen(sound: run.Outcome) -> None:
    right = recording_of(sound)
    columns = dict(right.imu.columns) | {"gyro_x": right.imu.columns["gyro_x"] * 1.01}
    wrong = replace(sound, recording=replace(right, imu=Stream(right.imu.t, columns)))
    assert judge.kind(wrong) != "invalid"
    assert "rate_x_+100 is wrong" in judge.violations("spike", wrong, right)


def test_a_table_that_turns_and_an_end_without_a_sentence_are_seen(sound: run.Outcome) -> None:
    bad = run.Outcome(recording=None, acquired=None, sentence="", is_at_rest=False)
    assert len(judge.violations("spike", bad, recording_of(sound))) == 2


def test_every_fault_is_drawn_and_the_same_seed_draws_the_same() -> None:
    assert drawn(3, 200) == drawn(3, 200)
    assert {fault.name for fault in drawn(3, 200)} == FAULTS.keys() - {"fixture_stays"}
