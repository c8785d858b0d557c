"""Faults of a station: what stops a run, what it is warned of, and that the table always stops."""

import asyncio
import signal
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import ACCEL, GYRO, Recording
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.specifications.jjf2003 import JJF2003
from tasks.station import procedures
from tasks.station.acquisition import GUARD_WALL_S, Progress, Sequencer
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tasks.words import cause_of
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.over_sockets import (
    MEASURED,
    SPEED,
    let_the_watchdog_bite,
    over_sockets,
    serving,
    table_and_watchdog,
)

STOPS = {
    "table_fault": "axis outer of the table reports fault: read the fault",
    "emergency_stop": "axis outer of the table reports emergency_stop: .* release",
    "interlock": "axis outer of the table reports interlock: close the guard",
    "never_settles": r"axis \w+ of the table has not settled at -?\d+ deg(/s)? within \d+ s",
    "unit_silent": r"the unit on socket://in-memory:1 has sent nothing for 3 s",
}
LINK_STOPS = {
    "modbus_silent": r"the station at 127\.0\.0\.1:\d+ does not answer",
    "modbus_exception": r"127\.0\.0\.1:\d+ refused .* exception 4 \(device failure\)",
    "modbus_address": r"127\.0\.0\.1:\d+ refused .* exception 2 \(illegal address\)",
    "modbus_busy": r"127\.0\.0\.1:\d+ refused .* exception 6",
    "modbus_zeros": r"the station's clock jumped back",
    "modbus_ones": "the table (reports fault|at .* gives 65535 samples)",
    "modbus_very_slow": r"the station at 127\.0\.0\.1:\d+ does not answer",
    "chamber_silent": r"127\.0\.0\.1:\d+ does not answer .* of device 2",
    "unit_cut": r"the unit's line socket://127\.0\.0\.1:\d+ broke",
}
LINK_LETS_BE = ("modbus_cut", "modbus_cut_often", "chamber_frozen", "busy_computer")


def in_rehearsal(name: str, others: tuple[str, ...]) -> Any:
    """The case of a fault; those that go the way of one that stays are for the rehearsal."""
    return pytest.param(name, marks=pytest.mark.rehearsal if name in others else ())


@pytest.fixture
def long(short) -> Procedure:
    """In its rates from 20 s of station time on, and still at 80 s."""
    update = {"rates_deg_s": (-50, 100, -30, 60), "dwell_s": 60.0}
    return short.model_copy(
        update={"steps": (*short.steps[:2], short.steps[2].model_copy(update=update))}
    )


def kept_until(
    stop: pytest.ExceptionInfo[Unusable], kept: Any, seconds: float, finished: int = 2
) -> None:
    """finished: segments that were measured at least."""
    sentence = str(stop.value)
    assert "the run stopped during “" in sentence
    assert f"is kept (finished segments: {len(kept.measured())})" in sentence
    assert kept.measured()[:finished] == MEASURED[:finished]
    for stream in ("imu", "table", "environment"):
        assert kept.stream(stream).t[-1] > seconds


@pytest.mark.parametrize(
    "name", [in_rehearsal(name, ("table_fault", "interlock")) for name in STOPS]
)
def test_fault_stops_the_run_with_its_sentence_and_keeps_what_was_recorded(name, long, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault(name, 25.0)])
    with pytest.raises(Unusable, match=STOPS[name]) as stop:
        station.acquire(long, kept)
    kept_until(stop, kept, 20.0)  # 25 s of the station, which began with the run; a flush is 4 s
    assert station.table.has_been_left
    assert "原因见日志" not in cause_of(stop.value).zh  # on the pages it is told, too
    last = kept.manifests[-1].model_extra["log"][-1]
    assert last["state"] == "stopped"
    assert name != "emergency_stop" or "emergency stop" in last["en"]


@pytest.mark.real_time
@pytest.mark.parametrize("name", [in_rehearsal(name, (*LINK_STOPS,)[1:]) for name in LINK_STOPS])
def test_fault_of_the_link_stops_the_run_and_keeps_what_was_recorded(name, long, kept):
    with (
        serving(VirtualStation(), SPEED, (StationFault(name, 80.0),)) as station,
        pytest.raises(Unusable, match=LINK_STOPS[name]) as stop,
    ):
        over_sockets(station, long, kept)
    # On a busy machine the run begins some seconds after the station was switched on.
    kept_until(stop, kept, 10.0, finished=1)


@pytest.mark.real_time
@pytest.mark.parametrize("name", [in_rehearsal(name, LINK_LETS_BE[1:]) for name in LINK_LETS_BE])
def test_fault_of_the_link_that_passes_costs_no_segment(name, short, kept):
    with serving(VirtualStation(), SPEED, (StationFault(name, 5.0),)) as station:
        over_sockets(station, short, kept)
    assert kept.measured() == MEASURED


WARNS = {
    "unit_garbage": ("unit_bad_frames", "unit_lost_samples"),
    "unit_drops": ("unit_lost_samples",),
    "stuck_channel": ("stuck_channel",),
    "spike": ("spikes",),
    "chamber_hot": ("air_temperature",),
    "table_rate_wrong": ("table_rate",),
}


@pytest.mark.parametrize(
    "name", [in_rehearsal(name, ("unit_drops", "table_rate_wrong")) for name in WARNS]
)
def test_fault_that_lets_the_run_end_is_a_warning_with_its_segments(name, short, kept):
    dwell_s = {"spike": 16.0, "unit_drops": 12.0}.get(name, 4.0)  # they come every 15 and 10 s
    steps = [step.model_copy(update={"dwell_s": dwell_s}) for step in short.steps[::2]]
    patient = short.model_copy(update={"steps": tuple(steps)})
    acquired = InMemoryStation(VirtualStation(), faults=[StationFault(name)]).acquire(patient, kept)
    remarks = [each for each in acquired.warnings if each.code != "segment_repeated"]
    assert {remark.code for remark in remarks} == set(WARNS[name])
    rates = {"rate_x_-50", "rate_x_+100"}
    for remark in remarks:
        assert rates <= set(remark.segments)
        assert remark.blocks_pass == (name == "chamber_hot")
        assert "rate_x_-50" in remark.en
        assert "rate_x_-50" in remark.zh
    assert (acquired.lost_samples > 0) == (name in ("unit_garbage", "unit_drops"))
    assert (acquired.bad_frames > 0) == (name == "unit_garbage")


# Every other fault of the station: what a run ends with holds, or is refused.

STANDS, REFUSED, STOPPED = "stands", "invalid", "stopped"
ENDS = {
    "table_shakes": STOPPED, "table_slow": STOPPED, "table_stalls": STOPPED,
    "settled_too_soon": STANDS, "encoder_frozen": REFUSED, "encoder_jumps": REFUSED,
    "encoder_scale": REFUSED, "encoder_noise": REFUSED, "capture_skips": REFUSED,
    "capture_empty": REFUSED, "chamber_cold": STANDS, "chamber_humid": STANDS,
    "supply_low": STANDS, "supply_cut": STOPPED, "unit_late": STANDS, "unit_repeats": STANDS,
    "unit_merges": REFUSED, "unit_cuts": REFUSED, "unit_swaps": STANDS, "unit_bit_flips": REFUSED,
    "unit_noise_line": STOPPED, "stuck_accel": REFUSED, "zero_readings": REFUSED,
    "saturated_axis": REFUSED, "outliers": REFUSED, "wrong_sign": REFUSED,
    "swapped_axes": REFUSED, "noisy_channel": STANDS, "unit_restarts": STOPPED,
    "unit_clock_drifts": REFUSED, "unit_clock_jumps": REFUSED, "unit_clock_stands": STOPPED,
}  # fmt: skip
AT_ONCE = ("table_stalls", "settled_too_soon", "encoder_jumps", "wrong_sign")
GYRO_TOLERANCE, ACCEL_TOLERANCE = np.radians(0.05), 0.01  # rad/s, m/s²: ten times the noise


@pytest.fixture(scope="module")
def brief() -> Procedure:
    """Six positions and two rates about each axis."""
    whole = procedures.load("jjf2003").model_dump()
    steps = [step | {"dwell_s": 3.0} for step in reversed(whole["steps"])]
    ups = {step["up"]: step for step in steps if step["kind"] == "position"}
    turns = {
        step["axis"]: step | {"rates_deg_s": (-50, 100)}
        for step in steps
        if step["kind"] == "rate_run"
    }
    return Procedure.model_validate(
        whole | {"steps": (*ups.values(), *turns.values()), "warm_up_s": 1.0}
    )


def readings(kept: Any) -> dict[str, np.ndarray]:
    """By segment the medians of gyros and accelerometers, as the estimation leaves out spikes."""
    imu = kept.stream("imu")
    return {
        segment.name: np.median(
            imu.stack(GYRO + ACCEL)[imu.rows(segment.t_start, segment.t_end)], axis=0
        )
        for segment in kept.manifests[-1].segments
        if segment.name in kept.measured()
    }


@pytest.fixture(scope="module")
def sound(brief, new_sink) -> dict[str, np.ndarray]:
    kept = new_sink()
    InMemoryStation(VirtualStation(), speed=160.0).acquire(brief, kept)
    return readings(kept)


def test_each_fault_has_a_test():
    elsewhere = {"fixture_stays", "power_cut", "modbus_slow", "bias_drifts"}
    assert FAULTS.keys() - elsewhere == {*ENDS, *STOPS, *LINK_STOPS, *LINK_LETS_BE, *WARNS}


@pytest.mark.parametrize(
    "name", [in_rehearsal(name, tuple(ENDS.keys() - AT_ONCE)) for name in ENDS]
)
def test_values_of_a_run_with_a_fault_are_those_of_the_sound_one_or_do_not_count(
    name, brief, sound, kept
):
    begins_s = 70.0 if name == "zero_readings" else 30.0  # most rests have a gravity
    station = InMemoryStation(VirtualStation(), speed=160.0, faults=[StationFault(name, begins_s)])
    if ENDS[name] == STOPPED:
        with pytest.raises(Unusable) as stop:
            station.acquire(brief, kept)
        assert "\n" not in str(stop.value)
        assert station.table.has_been_left
        return
    station.acquire(brief, kept)
    assert station.table.has_been_left
    made = Recording(kept.manifests[-1], kept.stream("imu"), kept.stream("table"))
    evaluation = evaluation_for(made)
    judged = calibrate(JJF2003, made, run="", code_version="", evaluation=evaluation).validity
    assert (judged.verdict == "invalid") == (ENDS[name] == REFUSED)
    if ENDS[name] == STANDS:
        found = readings(kept)
        assert found.keys() == sound.keys()
        off = np.array([np.abs(found[segment] - sound[segment]) for segment in sound])
        assert off[:, :3].max() < GYRO_TOLERANCE
        assert off[:, 3:].max() < ACCEL_TOLERANCE


@pytest.mark.real_time
def test_emergency_stop_is_never_reset_by_a_new_run(short, kept):
    with serving(VirtualStation(), SPEED, (StationFault("emergency_stop"),)) as station:
        asyncio.run(let_the_watchdog_bite(station))
        for _ in range(2):
            with pytest.raises(Unusable, match="reports emergency_stop"):
                over_sockets(station, short, kept)
    assert kept.manifests == []


def test_a_stop_is_noticed_at_once_while_nothing_else_asks_the_table(short, kept):
    """As the wait for a person who turns the unit over, in which no segment is measured."""
    patient = short.model_copy(update={"warm_up_s": 1e6})
    station = InMemoryStation(VirtualStation(), faults=[StationFault("emergency_stop", 100.0)])

    async def nobody_asks(sequencer: Any, planned: Any) -> None:
        await asyncio.sleep(1e6)

    with (
        patch.object(Sequencer, "run", nobody_asks),
        pytest.raises(Unusable, match="reports emergency_stop"),
    ):
        station.acquire(patient, kept)
    assert station.simulation.table.now - 100.0 < 2 * GUARD_WALL_S * SPEED
    assert station.table.has_been_left


def test_failing_sink_stops_the_table(short, kept):
    def full(name: str, stream: Any) -> None:
        if name == "imu":
            raise OSError(28, "No space left on device")

    kept.append = full
    station = InMemoryStation(VirtualStation())
    with pytest.raises(OSError, match="No space"):
        station.acquire(short, kept)
    assert station.table.has_been_left


# An operator ends a run: the table comes to rest, and what was recorded is kept.


@pytest.mark.real_time
def test_interrupt_stops_the_table_and_keeps_what_was_recorded(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            signal.raise_signal(signal.SIGINT)

    with serving(VirtualStation(), SPEED) as station:
        with pytest.raises(KeyboardInterrupt):
            over_sockets(station, short, kept, interrupt)
        state, watchdog = table_and_watchdog(station)
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
    assert kept.measured() == MEASURED[:2]
    assert len(kept.stream("imu"))


def test_what_is_on_the_line_when_a_run_is_interrupted_is_kept(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            raise KeyboardInterrupt

    station = InMemoryStation(VirtualStation())
    with pytest.raises(KeyboardInterrupt):
        station.acquire(short, kept, interrupt)
    assert station.table.has_been_left
    assert kept.measured() == MEASURED[:2]
    assert kept.stream("imu").t[-1] >= kept.manifests[-1].segments[-1].t_end - 0.5
