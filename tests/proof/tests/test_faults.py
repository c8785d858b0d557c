"""Runs with a fault, as the study holds them, on a procedure that is brief."""

from dataclasses import replace

import pytest

from schemas.recording import Recording, Stream
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tests.proof import faults
from tests.proof.faults import OF_THE_CLIENT, drawn


@pytest.fixture(autouse=True)
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "DWELL_S", 3.0)


@pytest.fixture(scope="module")
def sound() -> faults.Outcome:
    return faults.run_in_memory(faults.short_procedure(3.0), VirtualStation())


def recording_of(outcome: faults.Outcome) -> Recording:
    assert outcome.recording is not None
    return outcome.recording


@pytest.mark.parametrize("name", ["emergency_stop", "encoder_scale", "unit_merges"])
def test_a_run_with_a_fault_ends_as_it_should(name: str, sound: faults.Outcome) -> None:
    outcome = faults.run_with(StationFault(name, 40.0), VirtualStation())
    assert faults.violations(name, outcome, recording_of(sound)) == []


def test_values_that_are_wrong_in_a_run_that_stands_are_seen(sound: faults.Outcome) -> None:
    right = recording_of(sound)
    columns = dict(right.imu.columns) | {"gyro_x": right.imu.columns["gyro_x"] * 1.01}
    wrong = replace(sound, recording=replace(right, imu=Stream(right.imu.t, columns)))
    assert faults.kind(wrong) != "invalid"
    assert "rate_x_+100 is wrong" in faults.violations("spike", wrong, right)


def test_a_table_that_turns_and_an_end_without_a_sentence_are_seen(
    sound: faults.Outcome,
) -> None:
    bad = faults.Outcome(recording=None, acquired=None, sentence="", is_at_rest=False)
    assert len(faults.violations("spike", bad, recording_of(sound))) == 2


def test_every_fault_is_drawn_and_the_same_seed_draws_the_same() -> None:
    assert drawn(3, 200) == drawn(3, 200)
    every = FAULTS.keys() | OF_THE_CLIENT.keys()
    assert {fault.name for fault in drawn(3, 200)} == every - {"fixture_stays"}
