"""Runs a procedure on a station, real or virtual, from start to end."""

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Manifest
from schemas.station import StationFile
from schemas.text import Remark, Statement
from tasks.station.clock import StationClock
from tasks.station.connected_station import (
    OPERATOR,
    Bench,
    StopRequested,
    StopSwitch,
    connected,
    run_until_stopped,
    stopped_by,
)
from tasks.station.drivers.unit import UnitDriver
from tasks.station.monitor import MEASURED, remarks_on
from tasks.station.plan import check_attended, check_limits, check_procedure, plan
from tasks.station.ports import Ask, Table
from tasks.station.progress import Progress, Tracker
from tasks.station.recorder import Recorder, Sink, UnitRecorder
from tasks.station.run_manifest import Interrupted, ManifestBuilder, remaining
from tasks.station.sequencer import Sequencer
from tasks.words import Message, cause_of, message, texts

LEAVE_TIMEOUT_S = 8.0  # lines of text with a pause behind each take seconds
CLOCK_INTERVAL_S = 0.1
CANCEL_AGAIN_S = 0.1


@dataclass(frozen=True)
class Acquired:
    """What a run gave of a unit beside the streams, which are in the sink.

    given_up: why the run went on without the unit, as a sentence; cause: the same for the pages.
    """

    manifest: Manifest
    warnings: tuple[Remark, ...]
    bad_frames: int
    lost_samples: int
    given_up: str | None = None
    cause: Statement | None = None


@dataclass(frozen=True)
class NewRecording:
    """A recording to be made of one unit: the station as if it were alone, and the sink.

    earlier: an interrupted run that is continued; its streams are in the sink. operator: who
    carries it out.
    """

    station: StationFile
    sink: Sink
    recording_id: str
    earlier: Interrupted | None = None
    operator: str | None = None

    def recorder(
        self, driver: UnitDriver, clock: StationClock, procedure: Procedure
    ) -> UnitRecorder:
        """What makes it, from the present station time on."""
        manifest = ManifestBuilder(
            self.station, procedure, self.recording_id, clock.station_s, self.earlier, self.operator
        )
        return UnitRecorder(driver, clock, self.sink, manifest)


@dataclass(frozen=True)
class RunRequest:
    """A procedure to run on a station, and where recordings and progress go.

    `ask` has a person turn the units over if the station cannot. While `is_paused`, no further
    segment begins. `stop` ends the run at any moment. Raises Unusable, with one sentence, if
    procedure and station are incompatible.
    """

    station: StationFile
    procedure: Procedure
    recordings: tuple[NewRecording, ...]
    report: Callable[[Progress], None]
    ask: Ask | None = None
    is_paused: Callable[[], bool] = lambda: False
    stop: StopSwitch = field(default_factory=StopSwitch)

    def __post_init__(self) -> None:
        check_run(self.procedure, self.station, self.ask)


def check_run(procedure: Procedure, station: StationFile, ask: Ask | None) -> None:
    """Raises Unusable, naming step and way out, where a station cannot run a procedure."""
    for alone in station.per_unit():
        check_procedure(procedure, alone)
    check_limits(procedure, station)
    check_attended(procedure, station, ask)


def acquire(request: RunRequest) -> tuple[Acquired, ...]:
    """Run a procedure on a station and write its data to the sinks as they arrive.

    Streams, in SI: imu over the unit's own time stamps, table as captured encoder angles (rad,
    `<axis>_angle`) and environment over station time. The manifests are written after every
    finished segment. Returns one Acquired for each recording; a unit that fails is abandoned as
    long as another is sound.

    Raises Unusable, with one sentence, if the station does not answer or something fails on the
    way, and StopRequested where the switch was pressed; what was recorded until then is in the
    sink. Whatever ends the run, the table is stopped.
    """
    return run_until_stopped(_acquire(request), request.stop)


async def _acquire(request: RunRequest) -> tuple[Acquired, ...]:
    places = [recording.station for recording in request.recordings]
    async with connected(request.station, places, request.ask, request.stop) as bench:
        return await run(request, bench)


async def run(request: RunRequest, bench: Bench) -> tuple[Acquired, ...]:
    """A run on a bench that is connected; raises as `acquire` does."""
    texts(message("station-log-operator"))  # the catalogues are read before the watchdog counts
    clock = await _ready(bench)
    procedure = request.procedure
    planned = tuple(remaining(plan(procedure), _measured(request.recordings)))
    units = tuple(
        each.recorder(driver, clock, procedure)
        for each, driver in zip(request.recordings, bench.units, strict=True)
    )
    total_s = procedure.warm_up_s + sum(segment.planned_s for segment in planned)
    recorder = Recorder(bench, clock, procedure.environment, units)
    tracker = Tracker(request.report, clock, recorder, total_s, len(planned))
    tracker.enter("begun", procedure.title)
    recorder.write_manifests()
    sequencer = Sequencer(
        bench, request.station, clock, procedure, recorder, tracker, request.is_paused
    )
    try:
        await _until_the_first_ends(
            sequencer.run(planned),
            sequencer.guard(),
            _beside(bench, recorder.encoders.run()),
            recorder.climate.run(),
            recorder.run(),
        )
        await bench.table.leave()
    except BaseException as cause:
        await _stop_if_reachable(bench.table)
        recorder.enter("stopped", _cause_of_the_end(cause, request.stop))
        if isinstance(cause, Unusable):
            during = message("station-cause.during", now=tracker.now, cause=cause_of(cause))
            raise Unusable(_stopped(tracker.now, cause, recorder), during) from cause
        raise
    finally:
        for driver in bench.units:
            driver.end()
        _write_rest(recorder, procedure)
    return tuple(_acquired(unit, procedure) for unit in units)


async def _ready(bench: Bench) -> StationClock:
    """The table at home and held; whoever ends the run meanwhile stops it."""
    try:
        await bench.table.home()
        await bench.chamber.climate()
        return await _station_clock(bench.table)
    except (asyncio.CancelledError, KeyboardInterrupt, StopRequested):
        await _stop_if_reachable(bench.table)
        raise


def _measured(recordings: tuple[NewRecording, ...]) -> set[str]:
    """The segments that every one of some interrupted runs has."""
    of_each = [each.earlier.measured() if each.earlier else set() for each in recordings]
    return set.intersection(*of_each)


def _acquired(unit: UnitRecorder, procedure: Procedure) -> Acquired:
    return Acquired(
        manifest=unit.manifest.build(),
        warnings=remarks_on(unit.anomalies, unit.manifest.segments, procedure.environment),
        bad_frames=unit.driver.bad_frames,
        lost_samples=unit.unit.lost_samples,
        given_up=unit.given_up,
        cause=unit.cause,
    )


async def _beside(bench: Bench, work: Coroutine[Any, Any, None]) -> None:
    await bench.beside(work)


async def _station_clock(table: Table) -> StationClock:
    """A clock with two readings, so that it has an idea of the station's speed."""
    clock = StationClock()
    for pause_s in (CLOCK_INTERVAL_S, 0.0):
        state = await table.state()
        clock.update(state.station_s, state.wall_s, state.took_s)
        await asyncio.sleep(pause_s)
    return clock


async def _until_the_first_ends(*work: Coroutine[Any, Any, None]) -> None:
    """Run all side by side until one ends or fails; then the others are cancelled."""
    tasks = {asyncio.ensure_future(coroutine) for coroutine in work}
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    finally:
        await _cancel(tasks)


async def _cancel(tasks: set[asyncio.Task[None]]) -> None:
    """Cancel until all have ended: in Python 3.11 asyncio.wait_for, in which pymodbus waits,
    swallows a cancellation that arrives together with the answer."""
    running = tasks
    while running:
        for task in running:
            task.cancel()
        _, running = await asyncio.wait(running, timeout=CANCEL_AGAIN_S)
    await asyncio.gather(*tasks, return_exceptions=True)  # none goes unread


async def _stop_if_reachable(table: Table) -> None:
    """Stop the table as well as it can be; if it cannot be reached, its watchdog stops it."""
    with suppress(Unusable, OSError, TimeoutError):
        await asyncio.wait_for(table.leave(), LEAVE_TIMEOUT_S)


def _write_rest(recorder: Recorder, procedure: Procedure) -> None:
    """Write what is still on its way, and what was noticed; a unit may be what failed."""
    with suppress(Unusable):
        recorder.flush(final=True)
    for unit in recorder.units:
        unit.remember(remarks_on(unit.anomalies, unit.manifest.segments, procedure.environment))
        unit.write_manifest(recorder.encoders.table.time_half_width_s)


def _cause_of_the_end(cause: BaseException, stop: StopSwitch) -> Message:
    if stop.by or isinstance(cause, KeyboardInterrupt | asyncio.CancelledError):
        return stopped_by(stop.by or OPERATOR)
    return message("station-log-stopped", cause=cause_of(cause))


def _stopped(now: str, cause: Unusable, recorder: Recorder) -> str:
    segments = recorder.sound[0].manifest.segments
    measured = sum(segment.kind in MEASURED for segment in segments)
    return (
        f"the run stopped during “{now}”: {cause}; what was recorded until then is kept "
        f"(finished segments: {measured})"
    )
