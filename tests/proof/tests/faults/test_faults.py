"""Runs with a fault, as the study holds them, on a procedure that is brief."""

from dataclasses import replace

import pytest

from schemas.recording import Recording, Stream
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tests.proof import faults
from tests.proof.faults import OF_THE_CLIENT, Ended, drawn, page, run_of_client


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


def test_the_page_counts_how_runs_ended_and_lists_what_must_not_be() -> None:
    fault, slow = StationFault("spike", 12.5), StationFault("slow_disk", 3.0)
    found = [
        Ended(fault, "repeated", [], ""),
        Ended(fault, "invalid", ["the table still turns"], ""),
        Ended(slow, "recovered", [], ""),
    ]
    declared = page(found, seed=4, seconds=60.0)
    assert "3 runs of a short procedure (seed 4, 60 s)" in declared
    assert "1 violations" in declared
    assert "| `spike` | each 1500th sample is far off |  | 1 |  | 1 |  |" in declared
    assert "| `slow_disk` | each flush to the disk takes 1.5 s | 1 |" in declared
    assert declared.endswith("- spike@12.5: the table still turns\n")


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_a_run_on_a_slow_disk_is_whole() -> None:
    fault, procedure = StationFault("slow_disk", 20.0), faults.procedure_of("slow_disk")
    outcome = run_of_client(fault, procedure, VirtualStation())
    same = recording_of(faults.run_in_memory(procedure, VirtualStation()))
    assert outcome.sentence == ""
    assert faults.violations("slow_disk", outcome, same) == []
