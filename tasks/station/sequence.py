"""A run of a procedure on a station, real or virtual, from start to end."""

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from schemas.base import Unusable
from schemas.calibration import Remark
from schemas.procedure import Procedure
from schemas.recording import Manifest
from schemas.station import StationFile
from tasks.station.chamber import read_climate
from tasks.station.clock import StationClock
from tasks.station.drive import Driver
from tasks.station.findings import MEASURED, remarks_on
from tasks.station.fixture import Ask, check_attended, fixture_of
from tasks.station.labels import Labels
from tasks.station.legs import legs_of
from tasks.station.modbus import Link
from tasks.station.progress import Progress, Tracker
from tasks.station.recorder import Recorder, Sink
from tasks.station.suits import check_suits
from tasks.station.table import Table
from tasks.station.unit import Unit

LEAVE_S = 3.0
CLOCK_APART_S = 0.1
CANCEL_AGAIN_S = 0.1


@dataclass(frozen=True)
class Acquired:
    """What a run gave beside the streams, which are in the sink."""

    manifest: Manifest
    warnings: tuple[Remark, ...]
    bad_frames: int
    lost_samples: int


def acquire(
    station: StationFile,
    procedure: Procedure,
    sink: Sink,
    report: Callable[[Progress], None],
    *,
    recording_id: str,
    ask: Ask | None = None,
) -> Acquired:
    """Run a procedure on a station and write what it gives to the sink as it comes.

    Streams, in SI: imu over the unit's own time stamps, table as captured encoder angles
    (rad, `<axis>_angle`) and environment over station time. The manifest is written after
    every finished segment. `ask` has a person turn the unit over, where the station cannot.

    Raises Unusable, with one sentence, where procedure and station do not suit each other,
    where the station does not answer, and where something fails on the way; what was recorded
    until then is in the sink. Whatever ends the run, the table is told to stop.
    """
    check_suits(procedure, station)
    check_attended(procedure, station, ask)
    return asyncio.run(_acquire(_Order(station, procedure, sink, report, recording_id, ask)))


@dataclass(frozen=True)
class _Order:
    station: StationFile
    procedure: Procedure
    sink: Sink
    report: Callable[[Progress], None]
    recording_id: str
    ask: Ask | None


async def _acquire(order: _Order) -> Acquired:
    """Find everything before anything moves, then run."""
    link = Link(order.station.modbus_host, order.station.modbus_port)
    names = tuple(axis.name for axis in order.station.station.table_axes or ())
    try:
        table = await Table.find(link, names)
        await read_climate(link)
        clock = await _clock(table)
        with Unit(order.station.unit_link) as unit:
            return await _run(order, table, unit, clock)
    finally:
        link.close()


async def _run(order: _Order, table: Table, unit: Unit, clock: StationClock) -> Acquired:
    procedure, legs = order.procedure, legs_of(order.procedure)
    labels = Labels(order.station, procedure, order.recording_id, clock.station_s)
    total_s = procedure.warm_up_s + sum(leg.planned_s for leg in legs)
    tracker = Tracker(order.report, clock, total_s)
    recorder = Recorder(table, unit, clock, procedure.environment, order.sink, labels)
    recorder.begin()
    fixture, mount = fixture_of(order.station, table.link, order.ask), order.station.mount
    driver = Driver(table, fixture, mount, clock, procedure, recorder, labels, tracker)
    try:
        await _first_to_end(
            driver.run(legs), recorder.encoders.run(), recorder.climate.run(), recorder.run()
        )
        await table.leave()
    except BaseException as cause:
        await _stop_anyhow(table)
        if isinstance(cause, Unusable):
            raise Unusable(_stopped(tracker.now, cause, labels)) from cause
        raise
    finally:
        unit.end()
        _write_rest(recorder)
    return Acquired(
        manifest=labels.manifest(),
        warnings=remarks_on(recorder.findings, labels.segments, procedure.environment),
        bad_frames=unit.bad_frames,
        lost_samples=recorder.unit.lost_samples,
    )


async def _clock(table: Table) -> StationClock:
    """A clock with two readings, so that it has an idea of the station's speed."""
    clock = StationClock()
    for pause_s in (CLOCK_APART_S, 0.0):
        state = await table.state()
        clock.seen(state.station_s, state.wall_s)
        await asyncio.sleep(pause_s)
    return clock


async def _first_to_end(*work: Coroutine[Any, Any, None]) -> None:
    """Run all side by side until one ends or fails; then the others are cancelled."""
    tasks = {asyncio.ensure_future(each) for each in work}
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


async def _stop_anyhow(table: Table) -> None:
    """Stop the table as well as it can be; if it cannot be reached, its watchdog stops it."""
    with suppress(Unusable, OSError, TimeoutError):
        await asyncio.wait_for(table.leave(), LEAVE_S)


def _write_rest(recorder: Recorder) -> None:
    """Write what is still on its way; the unit may be what failed."""
    with suppress(Unusable):
        recorder.flush(final=True)
    recorder.write_manifest()


def _stopped(now: str, cause: Unusable, labels: Labels) -> str:
    measured = sum(segment.kind in MEASURED for segment in labels.segments)
    return (
        f"the run stopped during «{now}»: {cause}; what was recorded until then is kept "
        f"(finished segments: {measured})"
    )
