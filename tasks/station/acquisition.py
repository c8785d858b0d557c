"""Runs a procedure on a station, real or virtual, from start to end."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from schemas.base import Unusable
from schemas.procedure import Oscillation, Procedure, Refix
from schemas.recording import MEASURED, Alarm, Manifest, State
from schemas.station import StationFile
from schemas.text import Remark, Statement
from tasks.station.clock import StationClock, wall_s
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
from tasks.station.monitor import Anomaly, remarks_on
from tasks.station.plan import (
    PlannedSegment,
    SetPoint,
    check_attended,
    check_limits,
    check_procedure,
    move_s,
    nearest_turn,
    plan,
    rate_change_s,
)
from tasks.station.ports import Ask, Table, TableState, check_trips, oscillating
from tasks.station.recorder import Recorder, Sink, UnitRecorder
from tasks.station.run_manifest import Interrupted, ManifestBuilder, remaining
from tasks.words import Message, cause_of, message, texts

# Progress and state of a run.


REPORT_EVERY_S = 0.1


@dataclass(frozen=True)
class Progress:
    """What happens now, planned station seconds done and in all, wall seconds left.

    segment of segments: which is being measured. rates_hz, noise: of the streams, as LastRows
    has them. alarms: what was noticed, and how often.
    """

    now: str
    station_s_done: float
    station_s_total: float
    wall_s_left: float
    state: State = "begun"
    segment: int = 0
    segments: int = 0
    rates_hz: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    alarms: tuple[Alarm, ...] = ()


@dataclass
class Tracker:
    """Counts planned time: a segment counts for what was planned, however long it takes.

    Every state goes to the recorder's log.
    """

    report: Callable[[Progress], None]
    clock: StationClock
    recorder: Recorder
    total_s: float
    segments: int
    segment: int = 0
    now: str = ""
    _done_s: float = 0.0
    _planned_s: float = 0.0
    _began_s: float = 0.0
    _reported_wall_s: float = 0.0

    def add(self, planned_s: float) -> None:
        """A segment more is to be measured than was planned."""
        self.total_s += planned_s
        self.segments += 1

    def begin(self, state: State, now: str, planned_s: float) -> None:
        """Something begins that is planned to take this long; what came before it is done."""
        self._done_s += self._planned_s
        self._planned_s = planned_s
        self._began_s = self.clock.station_s
        self.segment += state in ("measuring", "repeating")
        self.enter(state, now)

    def enter(self, state: State, now: str) -> None:
        """The run enters a state within what was begun."""
        self.now = now
        cause = message(
            f"station-log-{state.replace('_', '-')}",
            now=now, number=self.segment, count=self.segments,
        )  # fmt: skip
        self.recorder.enter(state, cause)
        self._reported_wall_s = -REPORT_EVERY_S
        self.tick()

    def tick(self) -> None:
        """Report, unless it was reported just now."""
        now_s = wall_s()
        if now_s - self._reported_wall_s < REPORT_EVERY_S:
            return
        self._reported_wall_s = now_s
        within_s = min(self.clock.station_s - self._began_s, self._planned_s)
        done_s = self._done_s + within_s
        self._report(done_s, (self.total_s - done_s) / self.clock.speed)

    def end(self) -> None:
        """Everything is done."""
        self.enter("done", "done")
        self._report(self.total_s, 0.0)

    def _report(self, done_s: float, left_s: float) -> None:
        recorder = self.recorder
        self.report(
            Progress(
                now=self.now,
                station_s_done=done_s,
                station_s_total=self.total_s,
                wall_s_left=left_s,
                state=recorder.state,
                segment=self.segment,
                segments=self.segments,
                rates_hz=recorder.rates_hz,
                noise=recorder.noise,
                alarms=recorder.alarms,
            )
        )


# Takes the table through a procedure, segment by segment, while the streams are read.


SETTLING_MARGIN_S = 20.0  # station time beyond twice the computed duration
GUARD_WALL_S = 0.2
POLL_STATION_S = 0.25
REPEATS = 2
CATCH_UP_S = 3.0
CATCH_UP_STEP_S = 0.02


@dataclass
class Sequencer:
    """One run of a procedure on a bench. Raises Unusable where table or fixture fail.

    is_paused: asked before each segment.
    """

    bench: Bench
    station: StationFile
    clock: StationClock
    procedure: Procedure
    recorder: Recorder
    tracker: Tracker
    is_paused: Callable[[], bool]

    def __post_init__(self) -> None:
        self._table = self.bench.table
        self._spinning: PlannedSegment | None = None
        self._standing: tuple[float, ...] = ()  # angles that were asked for, deg

    async def run(self, planned: tuple[PlannedSegment, ...]) -> None:
        """Warm-up, every segment, those that failed again, and the last data in."""
        self.tracker.begin("warming_up", "warm-up", self.procedure.warm_up_s)
        await self._warm_up()
        measured: dict[str, PlannedSegment] = {}  # in the fixture's present attitude
        for segment in planned:
            if segment.refix is not None:
                await self._repeat_failed(measured)
                measured = {}
            await self._pause()
            self.tracker.begin("measuring", segment.text, segment.planned_s)
            await self._measure(segment)
            if segment.oscillation is None:
                measured[segment.name] = replace(segment, refix=None)
        await self._repeat_failed(measured)
        self.tracker.begin("finishing", "last data", 0.0)
        await self._catch_up(self.recorder.t_end)
        self.tracker.end()

    async def _pause(self) -> None:
        """Rest as long as the operator wants; the streams go on."""
        if not self.is_paused():
            return
        await self._stop_spinning()
        self.tracker.begin("paused", "paused", 0.0)
        while self.is_paused():
            await self._watch()
            await asyncio.sleep(GUARD_WALL_S)
        self.recorder.fill("pause", "transition", self.clock.station_s)

    async def _repeat_failed(self, measured: dict[str, PlannedSegment]) -> None:
        """Repeats segments that are not sound, for the units concerned."""
        for _ in range(REPEATS):
            await self._catch_up(self.recorder.t_end)
            failed = self.recorder.failed(measured)
            for name, units in failed.items():
                self.tracker.add(measured[name].planned_s)
                self.tracker.begin("repeating", measured[name].text, measured[name].planned_s)
                self.recorder.withdraw(name, units)
                await self._measure(measured[name])

    async def guard(self) -> None:
        """Look at the table for ever, also while a person turns the unit over."""
        while True:
            await self._watch()
            await asyncio.sleep(GUARD_WALL_S)

    async def _warm_up(self) -> None:
        warm_s = self.clock.station_s + self.procedure.warm_up_s
        await self._wait_until(warm_s)
        self.recorder.fill("warm", "settle", warm_s)

    async def _measure(self, planned: PlannedSegment) -> None:
        if planned.refix is not None:
            self.tracker.enter("turning_over", planned.refix.name)
            await self._refix(planned.refix)
            self.tracker.enter("measuring", planned.text)
        settled_s = await self._bring(planned)
        if planned.oscillation is not None:
            await self._oscillate(planned.oscillation, settled_s)
            return
        t_start = round(settled_s + self.procedure.settle_s, 6)
        await self._wait_until(t_start)
        if planned.kind == "rotation":
            # One encoder sample at rest before it turns; a fast station may be late.
            await self._wait_until(t_start + self._table.period_us / 1e6)
            late_s = self.clock.station_s - self.procedure.settle_s
            t_start = round(max(t_start, late_s), 6)
        self.recorder.fill("ramp" if planned.kind == "rate" else "move", "transition", settled_s)
        self.recorder.fill("settle", "settle", t_start)
        if planned.chamber_degc is not None:
            await self.bench.chamber.set_temperature(planned.chamber_degc)
        if planned.kind == "rotation":
            t_end = await self._turn(planned)
        else:
            t_end = round(t_start + planned.dwell_s, 6)
            await self._wait_until(t_end, settled=True)
        spin_axis = None if planned.spin_axis is None else self._table.names[planned.spin_axis]
        self.recorder.finish(planned.segment(t_start, t_end), spin_axis)

    async def _refix(self, refix: Refix) -> None:
        """Have the unit turned over, the table at zero meanwhile; warm up if it was off."""
        assert self.bench.fixture is not None  # check_attended
        await self._stop_spinning()
        await self._go_to((0.0,) * len(self._table.names))
        self.recorder.fill("move", "transition", self.clock.station_s)
        if refix.power_off:
            self.recorder.switched_off()
        on_s = await self.bench.fixture.turn(refix)
        if refix.power_off:
            self.recorder.switched_on(on_s)
        await self._watch()
        self.recorder.turned_over(None)
        self.recorder.fill("refix", "transition", self.clock.station_s)
        self.recorder.turned_over(refix)
        if refix.power_off:
            await self._warm_up()

    async def _oscillate(self, step: Oscillation, settled_s: float) -> None:
        """To and fro from rest to rest; what it was is told by the label alone."""
        self.recorder.fill("move", "transition", settled_s)
        await oscillating(self._table)(
            step.spin_axis, step.amplitude_deg, step.frequency_hz, step.cycles
        )
        await self._wait_until(self.clock.station_s + step.seconds)
        await self._settle((SetPoint(step.spin_axis, "rest"),), 0.0)
        self.recorder.fill(step.name, "transition", self.clock.station_s)

    async def _turn(self, planned: PlannedSegment) -> float:
        """Turn by whole turns, from rest to rest; the station time (s) at which it rests again."""
        axis, acceleration = planned.spin_axis or 0, self.procedure.acceleration_deg_s2
        by_deg = planned.turn_by_deg or 0.0
        target = SetPoint(axis, "angle", self._standing[axis] + by_deg)
        rate = abs(planned.rate_deg_s)
        await self._table.move_to(axis, target.value, rate, acceleration)
        await self._settle((target,), move_s(by_deg, rate, acceleration))
        t_end = round(self.clock.station_s + self.procedure.settle_s, 6)
        await self._wait_until(t_end)
        return t_end

    async def _bring(self, planned: PlannedSegment) -> float:
        """Bring the table to where a segment wants it; the station time at which it settled."""
        same_run = (
            self._spinning is not None
            and planned.kind == "rate"
            and self._spinning.spin_axis == planned.spin_axis
            and self._spinning.angles_deg == planned.angles_deg
        )
        if not same_run:
            await self._stop_spinning()
            await self._go_to(planned.angles_deg)
        if planned.kind == "rate":
            await self._spin(planned)
        return self.clock.station_s

    async def _stop_spinning(self) -> None:
        spinning, self._spinning = self._spinning, None
        if spinning is None:
            return
        axis = spinning.spin_axis or 0
        duration_s = rate_change_s(spinning.rate_deg_s, self.procedure.acceleration_deg_s2)
        await self._table.stop(axis)
        await self._settle((SetPoint(axis, "rest"),), duration_s)

    async def _go_to(self, angles_deg: tuple[float, ...]) -> None:
        rate, acceleration = self.procedure.move_rate_deg_s, self.procedure.acceleration_deg_s2
        state = await self._watch()
        targets = tuple(
            SetPoint(number, "angle", self._target(number, axis.angle_deg, angle))
            for number, (axis, angle) in enumerate(zip(state.axes, angles_deg, strict=True))
        )
        for target in targets:
            await self._table.move_to(target.axis, target.value, rate, acceleration)
        self._standing = tuple(target.value for target in targets)
        farthest = max(abs(t.value - state.axes[t.axis].angle_deg) for t in targets)
        await self._settle(targets, move_s(farthest, rate, acceleration))

    def _target(self, axis: int, now_deg: float, angle_deg: float) -> float:
        endless = self.station.limits.is_endless(self._table.names[axis])
        return nearest_turn(now_deg, angle_deg) if endless else angle_deg

    async def _spin(self, planned: PlannedSegment) -> None:
        axis, acceleration = planned.spin_axis or 0, self.procedure.acceleration_deg_s2
        before = self._spinning.rate_deg_s if self._spinning else 0.0
        self._spinning = planned
        await self._table.turn_at(axis, planned.rate_deg_s, acceleration)
        duration_s = rate_change_s(planned.rate_deg_s - before, acceleration)
        await self._settle((SetPoint(axis, "rate", planned.rate_deg_s),), duration_s)

    async def _settle(self, targets: tuple[SetPoint, ...], duration_s: float) -> None:
        """Wait for the set-points: twice the computed duration and SETTLING_MARGIN_S."""
        limit_s = 2 * duration_s + SETTLING_MARGIN_S
        state = await self._watch()
        began_s = state.station_s
        while True:
            late = [target for target in targets if not target.is_reached(state.axes[target.axis])]
            if not late:
                return
            if state.station_s - began_s > limit_s:
                raise late[0].lateness(self._table.names, state, limit_s)
            await asyncio.sleep(self.clock.wall(POLL_STATION_S, 0.005, 0.1))
            state = await self._watch()

    async def _wait_until(self, station_s: float, settled: bool = False) -> None:
        """Wait for a station time; with `settled`, note which axes were not settled meanwhile."""
        while self.clock.station_s < station_s:
            left_s = station_s - self.clock.station_s
            await asyncio.sleep(self.clock.wall(left_s, 0.002, 0.1))
            state = await self._watch()
            for name, axis in zip(self._table.names, state.axes, strict=True):
                if settled and state.station_s < station_s and not axis.is_settled:
                    at_s = state.station_s
                    self.recorder.note(Anomaly("table_unsettled", at_s, at_s, subject=name))

    async def _catch_up(self, station_s: float) -> None:
        """Wait for the last data while they come; a unit that is silent says so itself."""
        came_s = wall_s()
        while self.recorder.reached_s < station_s and wall_s() - came_s < CATCH_UP_S:
            before_s = self.recorder.reached_s
            self.recorder.flush(final=True)
            came_s = wall_s() if self.recorder.reached_s > before_s else came_s
            await asyncio.sleep(CATCH_UP_STEP_S)

    async def _watch(self) -> TableState:
        """Read the table, and raise Unusable if it has failed."""
        before_s = self.clock.station_s
        state = await self._table.state()
        self.clock.update(state.station_s, state.wall_s, state.took_s)
        check_trips(state, self._table.names)
        self.clock.check(before_s)
        self.tracker.tick()
        return state


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
