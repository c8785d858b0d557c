"""The table brought through a procedure, stretch by stretch, while the feeds run."""

import asyncio

from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from schemas.recording import Mount
from tasks.station.clock import StationClock
from tasks.station.findings import Finding
from tasks.station.fixture import Fixture, mount_in
from tasks.station.goals import Goal
from tasks.station.labels import Labels
from tasks.station.legs import Leg
from tasks.station.progress import Tracker
from tasks.station.ramps import move_s, nearest_turn, rate_change_s
from tasks.station.recorder import Recorder
from tasks.station.table import Table, TableState, check

STILL_S = 5.0  # wall time a station's clock may stand still
PATIENCE_S = 20.0  # station time beyond twice the computed duration
POLL_STATION_S = 0.25
CATCH_UP_S = 3.0
STEP_S = 0.02


class Driver:
    """One run of a procedure on a table. Raises Unusable where table or fixture fail.

    mount: how the unit sits in its fixture, which is None where nobody can turn it over.
    """

    def __init__(
        self,
        table: Table,
        fixture: Fixture | None,
        mount: Mount,
        clock: StationClock,
        procedure: Procedure,
        recorder: Recorder,
        labels: Labels,
        tracker: Tracker,
    ) -> None:
        self._table = table
        self._fixture = fixture
        self._mount = mount
        self._clock = clock
        self._procedure = procedure
        self._recorder = recorder
        self._labels = labels
        self._tracker = tracker
        self._spinning: Leg | None = None
        self._standing: tuple[float, ...] = ()  # angles that were asked for, deg

    async def run(self, legs: tuple[Leg, ...]) -> None:
        """Warm-up, every stretch, and the last data in."""
        self._tracker.begin("warm-up", self._procedure.warm_up_s)
        await self._warm_up()
        for leg in legs:
            self._tracker.begin(leg.text, leg.planned_s)
            await self._leg(leg)
        self._tracker.begin("last data", 0.0)
        await self._catch_up(self._labels.segments[-1].t_end)
        self._tracker.end()

    async def _warm_up(self) -> None:
        warm_s = self._clock.station_s + self._procedure.warm_up_s
        await self._wait_until(warm_s)
        self._labels.cover("warm", "settle", warm_s)

    async def _leg(self, leg: Leg) -> None:
        if leg.refix is not None:
            await self._refix(leg.refix)
        settled_s = await self._bring(leg)
        t_start = round(settled_s + self._procedure.settle_s, 6)
        await self._wait_until(t_start)
        if leg.kind == "rotation":
            late_s = self._clock.station_s - self._procedure.settle_s
            t_start = round(max(t_start, late_s), 6)  # a fast station may be late
        self._labels.cover("ramp" if leg.kind == "rate" else "move", "transition", settled_s)
        self._labels.cover("settle", "settle", t_start)
        if leg.kind == "rotation":
            t_end = await self._turn(leg)
        else:
            t_end = round(t_start + leg.dwell_s, 6)
            await self._wait_until(t_end, settled=True)
        spin_axis = None if leg.spin_axis is None else self._table.names[leg.spin_axis]
        self._recorder.finish(leg.segment(t_start, t_end), spin_axis)

    async def _refix(self, refix: Refix) -> None:
        """Have the unit turned over, the table at zero meanwhile; warm up if it was off."""
        assert self._fixture is not None  # check_attended
        await self._stop_spinning()
        await self._go_to((0.0,) * len(self._table.names))
        self._labels.cover("move", "transition", self._clock.station_s)
        if refix.power_off:
            self._recorder.unit.switched_off()
        on_s = await self._fixture.turn(refix)
        if refix.power_off:
            self._recorder.unit.switched_on(on_s)
        await self._watch()
        self._labels.cover("refix", "transition", self._clock.station_s)
        self._labels.mount = mount_in(refix.mount, self._mount)
        if refix.power_off:
            await self._warm_up()

    async def _turn(self, leg: Leg) -> float:
        """Turn by whole turns, from rest to rest; the station time (s) at which it rests again."""
        axis, acceleration = leg.spin_axis or 0, self._procedure.acceleration_deg_s2
        by_deg = leg.turn_by_deg or 0.0
        goal = Goal(axis, "angle", self._standing[axis] + by_deg)
        rate = abs(leg.rate_deg_s)
        await self._table.go_to(axis, goal.value, rate, acceleration)
        await self._settled((goal,), move_s(by_deg, rate, acceleration))
        t_end = round(self._clock.station_s + self._procedure.settle_s, 6)
        await self._wait_until(t_end)
        return t_end

    async def _bring(self, leg: Leg) -> float:
        """Bring the table to where a stretch wants it; the station time at which it settled."""
        same_run = (
            self._spinning is not None
            and leg.kind == "rate"
            and self._spinning.spin_axis == leg.spin_axis
            and self._spinning.angles_deg == leg.angles_deg
        )
        if not same_run:
            await self._stop_spinning()
            await self._go_to(leg.angles_deg)
        if leg.kind == "rate":
            await self._spin(leg)
        return self._clock.station_s

    async def _stop_spinning(self) -> None:
        leg, self._spinning = self._spinning, None
        if leg is None:
            return
        axis = leg.spin_axis or 0
        duration_s = rate_change_s(leg.rate_deg_s, self._procedure.acceleration_deg_s2)
        await self._table.ramp_to_rest(axis)
        await self._settled((Goal(axis, "rest"),), duration_s)

    async def _go_to(self, angles_deg: tuple[float, ...]) -> None:
        rate, acceleration = self._procedure.move_rate_deg_s, self._procedure.acceleration_deg_s2
        state = await self._watch()
        goals = tuple(
            Goal(number, "angle", nearest_turn(axis.angle_deg, angle))
            for number, (axis, angle) in enumerate(zip(state.axes, angles_deg, strict=True))
        )
        for goal in goals:
            await self._table.go_to(goal.axis, goal.value, rate, acceleration)
        self._standing = tuple(goal.value for goal in goals)
        farthest = max(abs(goal.value - state.axes[goal.axis].angle_deg) for goal in goals)
        await self._settled(goals, move_s(farthest, rate, acceleration))

    async def _spin(self, leg: Leg) -> None:
        axis, acceleration = leg.spin_axis or 0, self._procedure.acceleration_deg_s2
        before = self._spinning.rate_deg_s if self._spinning else 0.0
        self._spinning = leg
        await self._table.hold_rate(axis, leg.rate_deg_s, acceleration)
        duration_s = rate_change_s(leg.rate_deg_s - before, acceleration)
        await self._settled((Goal(axis, "rate", leg.rate_deg_s),), duration_s)

    async def _settled(self, goals: tuple[Goal, ...], duration_s: float) -> None:
        """Wait until the goals are reached, for twice the computed duration and PATIENCE_S."""
        limit_s = 2 * duration_s + PATIENCE_S
        state = await self._watch()
        began_s = state.station_s
        while True:
            late = [goal for goal in goals if not goal.is_reached(state.axes[goal.axis])]
            if not late:
                return
            if state.station_s - began_s > limit_s:
                raise Unusable(self._lateness(late[0], state, limit_s))
            await asyncio.sleep(self._clock.wall(POLL_STATION_S, 0.005, 0.1))
            state = await self._watch()

    def _lateness(self, goal: Goal, state: TableState, limit_s: float) -> str:
        axis = state.axes[goal.axis]
        return (
            f"axis {self._table.names[goal.axis]} of the table has not settled {goal.text()} "
            f"within {limit_s:.0f} s (angle {axis.angle_deg:.4f} deg, rate "
            f"{axis.rate_deg_s:.4f} deg/s): check its load, its balance and its servo"
        )

    async def _wait_until(self, station_s: float, settled: bool = False) -> None:
        """Wait for a station time; with `settled`, say which axes were not settled meanwhile."""
        while self._clock.station_s < station_s:
            left_s = station_s - self._clock.station_s
            await asyncio.sleep(self._clock.wall(left_s, 0.002, 0.1))
            state = await self._watch()
            for name, axis in zip(self._table.names, state.axes, strict=True):
                if settled and state.station_s < station_s and not axis.has("settled"):
                    at = state.station_s
                    self._recorder.findings.append(Finding("table_unsettled", at, at, 1.0, name))

    async def _catch_up(self, station_s: float) -> None:
        """Wait for the last data; a unit that is silent by now says so itself."""
        for _ in range(round(CATCH_UP_S / STEP_S)):
            self._recorder.flush(final=True)
            if self._recorder.has_passed(station_s):
                return
            await asyncio.sleep(STEP_S)

    async def _watch(self) -> TableState:
        """Read the table, and raise Unusable if it has failed."""
        before_s = self._clock.station_s
        state = await self._table.state()
        self._clock.seen(state.station_s, state.wall_s)
        check(state, self._table.names)
        if state.station_s < before_s:
            raise Unusable(
                f"the station's clock went back from {before_s:.3f} s to {state.station_s:.3f} s, "
                f"as after a restart: start the run again"
            )
        if self._clock.stands_still_s > STILL_S:
            raise Unusable(
                f"the station's clock has stood at {state.station_s:.3f} s for {STILL_S:g} s: "
                f"restart the controller"
            )
        self._tracker.tick()
        return state
