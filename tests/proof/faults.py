"""Runs whose own computer fails: its disk is slow or stands, or it is killed and goes on later."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

import numpy as np

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.recording import ACCEL, GYRO, MEASURED, Recording, Segment
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.formats.mcap.chunks import ChunkWriter
from storage.home import Home
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.specifications.register import specification_for
from tasks.stages.acquire import acquire_run
from tasks.station.acquisition import Acquired
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tasks.station.virtual.servers import running
from tests.proof.kills import RESUMES_SPEED as CLIENTS_SPEED
from tests.proof.kills import killed_and_resumed
from tests.proof.study import Count, Out, Seed, Write, hold, table
from tests.proof.virtual_runs import Outcome, Sink, comes_to_rest, run_in_memory, short_procedure
from tests.tasks.station.over_sockets import ignore, over_sockets

FLUSHES_S = {"slow_disk": 1.5, "standing_disk": 12.0}  # wall time
OF_THE_CLIENT = {
    "slow_disk": f"each flush to the disk takes {FLUSHES_S['slow_disk']:g} s",
    "standing_disk": f"each flush to the disk takes {FLUSHES_S['standing_disk']:g} s",
    "client_killed": "the acquisition is killed, and goes on with `--resume`",
}


def run_of_client(fault: StationFault, procedure: Procedure, config: VirtualStation) -> Outcome:
    """A run, as `acquire` carries it out, with a fault of OF_THE_CLIENT."""
    with TemporaryDirectory() as folder, running(config, CLIENTS_SPEED) as station:
        home = Home(Path(folder))
        recording, acquired, sentence = None, None, ""
        try:
            run, acquired = _acquired(fault, station, procedure, home)
            recording = runs.load(run, home)
        except (Unusable, BrokenOff) as stop:
            sentence = str(stop)
        is_at_rest = comes_to_rest(station, config.unit.gyro.lsb)
    return Outcome(recording, acquired, sentence, is_at_rest)


def _acquired(
    fault: StationFault, station: StationFile, procedure: Procedure, home: Home
) -> tuple[Run, Acquired]:
    after_s = fault.at_seconds / CLIENTS_SPEED
    if fault.name == "client_killed":
        return killed_and_resumed(station, procedure, home, after_s)[:2]
    with _flushing(FLUSHES_S[fault.name], after_s):
        (kept,) = acquire_run(station, procedure, home, ignore).kept
    return kept


@contextmanager
def _flushing(takes_s: float, after_s: float) -> Iterator[None]:
    """A disk whose flushes take so long, from so many seconds after the block's beginning."""
    began_s, flush = time.monotonic(), ChunkWriter.flush

    def slowly(writer: ChunkWriter) -> None:
        if time.monotonic() - began_s > after_s:
            time.sleep(takes_s)
        flush(writer)

    with patch.object(ChunkWriter, "flush", slowly):
        yield


# One run on a virtual station with a fault: how it ended, and what it left.

SPEED = 100.0  # times the clock
SLOW_ANSWERS = {"modbus_slow": 10.0}  # at which an answer is late by 2 s of the station's time
DWELL_S = 31.0  # what the specification asks, and a little more
# Faults of the links and of the station's computer, which a run in this process has not.
OVER_SOCKETS = frozenset({
    "modbus_silent", "modbus_exception", "modbus_address", "modbus_busy", "modbus_zeros",
    "modbus_ones", "modbus_slow", "modbus_very_slow", "modbus_cut", "modbus_cut_often",
    "chamber_silent", "chamber_frozen", "busy_computer", "power_cut", "unit_cut",
})  # fmt: skip
IN_REAL_TIME = OVER_SOCKETS | OF_THE_CLIENT.keys()
UNSEEN = ("power_cut", "unit_cut")  # the unit does not tell any more whether the table turns


def procedure_of(name: str) -> Procedure:
    """That of runs with a fault: in real time a briefer one."""
    return short_procedure(DWELL_S, "x" if name in IN_REAL_TIME else "xyz")


def run_with(fault: StationFault, config: VirtualStation) -> Outcome:
    """A run with a fault."""
    if fault.name in OF_THE_CLIENT:
        return run_of_client(fault, procedure_of(fault.name), config)
    if fault.name in OVER_SOCKETS:
        return _over_sockets(fault, config)
    return run_in_memory(procedure_of(fault.name), config, [fault])


def _over_sockets(fault: StationFault, config: VirtualStation) -> Outcome:
    with running(config, SLOW_ANSWERS.get(fault.name, SPEED), [fault]) as station:
        sink = Sink()
        try:
            acquired, sentence = over_sockets(station, procedure_of(fault.name), sink), ""
        except Unusable as stop:
            acquired, sentence = None, str(stop)
        at_rest = None if fault.name in UNSEEN else comes_to_rest(station, config.unit.gyro.lsb)
    return Outcome(sink.recording() if acquired else None, acquired, sentence, at_rest)


# Whether a run with a fault ended as it should, held against the same run without one.
#
# Values of a run that is not invalid stand, and must be those of the run without a fault.

LONGEST_SENTENCE = 600
GYRO_TOLERANCE, ACCEL_TOLERANCE = np.radians(0.05), 0.01  # rad/s, m/s²: ten times the noise
TABLE_TOLERANCE = np.radians(0.05)  # rad/s
LEAST_ROWS = 0.985  # of those that the sound run has; a unit's clock that is 1 % fast is no loss
OUT_OF_LIMITS = ("chamber_hot", "chamber_cold", "chamber_humid", "supply_low")


def violations(name: str, outcome: Outcome, sound: Recording) -> list[str]:
    """What must not be; sound: the run without the fault."""
    found = [] if outcome.is_at_rest is not False else ["the table still turns"]
    if outcome.recording is None:
        if not outcome.sentence or "\n" in outcome.sentence:
            found.append("it did not end with one sentence")
        elif len(outcome.sentence) > LONGEST_SENTENCE:
            found.append(f"its sentence has {len(outcome.sentence)} characters")
        return found
    judged = verdict(outcome.recording)
    if judged == "invalid":
        return found
    found += _wrong_values(outcome.recording, sound)
    if name in OUT_OF_LIMITS and judged == "valid":
        found.append("it is valid, out of its limits")
    return found


def verdict(recording: Recording) -> str:
    """The verdict on the run, as `acquire` gives it."""
    calibration = calibrate(
        specification_for(recording.manifest.standard), recording, run="", code_version="",
        evaluation=evaluation_for(recording),
    )  # fmt: skip
    return calibration.validity.verdict


def kind(outcome: Outcome) -> str:
    """stopped, repeated, invalid, remarks or recovered."""
    if outcome.recording is None or outcome.acquired is None:
        return "stopped"
    judged = verdict(outcome.recording)
    if judged != "valid":
        return judged
    codes = {remark.code for remark in outcome.acquired.warnings}
    return "repeated" if "segment_repeated" in codes else "recovered"


def _wrong_values(recording: Recording, sound: Recording) -> list[str]:
    """Segments of a valid run whose means are not those of the sound one, or that are not whole."""
    wanted = {segment.name: segment for segment in _measured(sound)}
    found = [
        f"{segment.name} is wrong"
        for segment in _measured(recording)
        if not _agree(recording, segment, sound, wanted[segment.name])
    ]
    missing = wanted.keys() - {segment.name for segment in _measured(recording)}
    return found + [f"{name} is missing" for name in sorted(missing)]


def _measured(recording: Recording) -> list[Segment]:
    return [s for s in recording.manifest.segments or () if s.kind in MEASURED]


def _agree(recording: Recording, segment: Segment, sound: Recording, other: Segment) -> bool:
    (gyro, accel, table, rows), wanted = _figures(recording, segment), _figures(sound, other)
    return bool(
        np.abs(gyro - wanted[0]).max() < GYRO_TOLERANCE
        and np.abs(accel - wanted[1]).max() < ACCEL_TOLERANCE
        and np.abs(table - wanted[2]).max() < TABLE_TOLERANCE
        and rows > LEAST_ROWS * wanted[3] * _length(segment) / _length(other)
    )


def _length(segment: Segment) -> float:
    return segment.t_end - segment.t_start


def _figures(
    recording: Recording, segment: Segment
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Medians of gyro and accelerometer, mean rates of the table's axes, samples of the unit.

    Medians, because the estimation leaves far samples out, too.
    """
    imu, table = recording.imu, recording.table
    assert table is not None
    rows, turned = (stream.rows(segment.t_start, segment.t_end) for stream in (imu, table))
    angles = np.array([values[turned] for values in table.columns.values()])
    t = table.t[turned]
    rates = (angles[:, -1] - angles[:, 0]) / (t[-1] - t[0])
    return (
        np.median(imu.channels(GYRO, rows), axis=1),
        np.median(imu.channels(ACCEL, rows), axis=1),
        rates,
        rows.stop - rows.start,
    )


# Random faults at random times, each in a run of its own; a table of how they ended.

LATEST_S = 600.0  # station time: a sound run takes a bit longer
LATEST_IN_REAL_TIME_S = 200.0  # of a briefer run, on a station that is slower than it was asked
KINDS = ("recovered", "repeated", "remarks", "invalid", "stopped")
AT_ONCE = 6  # some wait for their stations
NOT_IN_THIS_PROCEDURE = ("fixture_stays",)


WHAT_HAPPENS = {name: what for name, (_, what) in FAULTS.items()} | OF_THE_CLIENT


@dataclass(frozen=True)
class Ended:
    """How a run with a fault ended: one of KINDS, with what must not be, and its sentence."""

    fault: StationFault
    how: str
    violations: list[str]
    sentence: str


def drawn(seed: int, count: int) -> list[StationFault]:
    """As many faults, every name in turn, each at a random time."""
    rng = np.random.default_rng(seed)
    names = [name for name in WHAT_HAPPENS if name not in NOT_IN_THIS_PROCEDURE]
    order = [str(name) for _ in range(count // len(names) + 1) for name in rng.permutation(names)]
    return [
        StationFault(name, round(rng.uniform(0.0, _latest_s(name)), 1)) for name in order[:count]
    ]


def _latest_s(name: str) -> float:
    return LATEST_IN_REAL_TIME_S if name in IN_REAL_TIME else LATEST_S


def faults(count: Count = 200, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Runs of a virtual station, each with a random fault at a random time."""
    work = {
        f"{seed}-{number:04d}-{each.name}": each for number, each in enumerate(drawn(seed, count))
    }
    hold("faults", work, run_one, partial(page, seed=seed), out, write=write, at_once=AT_ONCE,
         faults=lambda one: (f"{one.fault}: {each}" for each in one.violations))  # fmt: skip


def resumes(count: Count = 10, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Acquisitions that are killed at random moments and go on, against an uninterrupted run."""
    rng = np.random.default_rng(seed)
    moments = (round(rng.uniform(0.0, LATEST_IN_REAL_TIME_S), 1) for _ in range(count))
    work = {f"{seed}-{n:04d}": StationFault("client_killed", at) for n, at in enumerate(moments)}
    hold("resumes", work, run_one, partial(page, seed=seed), out, write=write, at_once=AT_ONCE,
         faults=lambda one: (f"{one.fault}: {each}" for each in one.violations))  # fmt: skip


def run_one(fault: StationFault) -> Ended:
    """One run with a fault, and how it is judged."""
    try:
        outcome = run_with(fault, VirtualStation())
    except Unusable as failure:
        return Ended(fault, "stopped", [f"it was not held: {failure}"], "")
    against = violations(fault.name, outcome, _sound(procedure_of(fault.name)))
    return Ended(fault, kind(outcome), against, outcome.sentence)


@cache
def _sound(procedure: Procedure) -> Recording:
    sound = run_in_memory(procedure, VirtualStation()).recording
    assert sound is not None
    return sound


def page(found: Sequence[Ended], seed: int) -> str:
    """The table of how runs with each fault ended."""
    ended: dict[str, Counter[str]] = {}
    for one in found:
        ended.setdefault(one.fault.name, Counter())[one.how] += 1
    wrong = [f"{one.fault}: {'; '.join(one.violations)}" for one in found if one.violations]
    rows = [
        (f"`{name}`", WHAT_HAPPENS[name], *(counts[how] or "" for how in KINDS))
        for name, counts in sorted(ended.items())
    ]
    return "\n".join([
        "# Runs in which something fails", "",
        f"{len(found)} runs of a short procedure (seed {seed}), each with one "
        "fault of the station or of the computer that acquires, from a random time on: "
        f"{len(wrong)} violations.", "",
        "Recovered: valid, with the values of the sound run. Repeated: so, after segments were "
        "measured again. Remarks: with those values, and no unit passes. Invalid: no "
        "verdict. Stopped: one sentence. The table is at rest at the end.", "",
        *table(("fault", "what happens", *KINDS), rows), "",
        *(f"- {each}" for each in wrong),
    ]).rstrip() + "\n"  # fmt: skip
