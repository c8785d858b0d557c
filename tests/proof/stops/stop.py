"""One press at a random moment, and what it left."""

import http.client
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path

from flows.station_page import StationPage, page_server
from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.run_log import ENDED
from schemas.station import StationFile
from schemas.stop import Stopped
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.station_lock import end_dead_statuses, is_held, statuses
from storage.station_stop import request_in
from tasks.stages.stop import stop_station
from tests.proof.faults.run_with_fault import short_procedure
from tests.proof.stops.observed import Observed
from tests.proof.stops.station_run import HANGS, begin
from tests.tasks.station.over_sockets import table_and_watchdog

WAYS = ("command", "button", "page", "SIGTERM", "SIGTERM twice", "Ctrl-C", "kill -9")
DOWN = ("nothing", "home", "database", "Prefect", "the run hangs")
BY = "Li"
BOUND_S = 2.0  # from the press until the table is at rest
WATCHDOG_S = 5.0  # of the station's table, and then the ramp
RAMP_S = 3.5  # from 300 deg/s with 120 deg/s2, and a margin
START_S, END_S, GOES_ON_S = 90.0, 60.0, 400.0  # of a machine that is busy with other work
LONGEST_S = 60.0  # station time after the first move at which the press comes at the latest
SOURCE = Path(__file__).parents[3]


@dataclass(frozen=True)
class Pressed:
    """One press. speed: of the station's clock. turning: whether the table moved at the press.

    rest_s: from the press until the table was at rest, wall time; confirmed_s: until the answer.
    resumed: whether the run then went on to its end; null where that was not tried.
    """

    seed: int
    way: str
    down: str
    speed: float
    turning: bool
    rest_s: float
    confirmed_s: float
    faults: tuple[str, ...]
    resumed: bool | None = None

    @property
    def bound_s(self) -> float:
        return BOUND_S if self.way != "kill -9" else WATCHDOG_S + RAMP_S


def procedure() -> Procedure:
    """Rates up to those of JJF 2003, then positions; brief, so that it can be gone on with."""
    short = short_procedure(2.0, "z")
    steps = sorted(short.model_dump()["steps"], key=lambda step: step["kind"] == "position")
    steps[0] |= {"rates_deg_s": (-300, -100, 100, 300)}
    return Procedure.model_validate(short.model_dump() | {"steps": steps})


def press(
    seed: int, folder: Path, station: StationFile, speed: float, lsb: float, resume: bool
) -> Pressed:
    """A run on a station in a new folder, and a press. speed: of the station's clock.
    lsb: of the unit's gyros, rad/s.
    """
    drawn = random.Random(seed)
    way, down = WAYS[seed % len(WAYS)], DOWN[seed % len(DOWN)]
    after_s = drawn.uniform(0.0, LONGEST_S) / speed
    room = _Room(folder, station)
    run = begin(folder, room.environment)
    observed = Observed(station, lsb)
    try:
        room.wait_for_readings(run)
        time.sleep(after_s)
        press_it = _prepared(way, run, room)
        with room.without(down):
            turning, pressed_s = observed.turns, time.monotonic()
            stopped = press_it()
            confirmed_s = time.monotonic() - pressed_s
            run.join(END_S)
            time.sleep(max(0.0, _until_s(way) - (time.monotonic() - pressed_s)))
        rest_s = max(observed.moved_s - pressed_s, 0.0)
        faults = tuple(room.faults(way, run, stopped))
    finally:
        run.kill()
        run.join()
        observed.close()
    found = Pressed(seed, way, down, speed, turning, rest_s, confirmed_s, faults)
    if rest_s > found.bound_s:
        late = f"at rest {rest_s:.2f} s after the press"
        found = replace(found, faults=(*faults, late))
    return replace(found, resumed=room.goes_on()) if resume else found


def _until_s(way: str) -> float:
    """For how long it is watched whether the table turns again."""
    return WATCHDOG_S + RAMP_S if way == "kill -9" else 2 * BOUND_S


def _prepared(way: str, run: BaseProcess, room: "_Room") -> Callable[[], Stopped | None]:
    """What presses; it gives what the stop says, where it says anything."""
    if way == "button":
        return partial(stop_station, room.id, BY, room.home)
    if way == "page":
        return _page(room)
    if way == "command":
        return partial(_by_command, room)
    return partial(_by_signal, way, run.pid or 0)


def _by_signal(way: str, process: int) -> None:
    if way == "kill -9":
        os.kill(process, signal.SIGKILL)
        return
    os.kill(process, signal.SIGINT if way == "Ctrl-C" else signal.SIGTERM)
    if way == "SIGTERM twice":
        time.sleep(0.15)
        os.kill(process, signal.SIGTERM)


def _by_command(room: "_Room") -> Stopped:
    ended = subprocess.run(
        [sys.executable, "-m", "flows.cli", "station", "stop", room.id, "--by", BY, "--json"],
        cwd=SOURCE, env=os.environ | room.environment, capture_output=True, text=True,
    )  # fmt: skip
    if not ended.stdout:
        raise Unusable(ended.stderr)
    return Stopped.model_validate_json(ended.stdout)


def _page(room: "_Room") -> Callable[[], Stopped | None]:
    """The page, as it stands in a browser, and what its button sends."""
    served = StationPage(room.id, BY, room.home)
    server = page_server(served, 0)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    line = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    line.request("GET", "/")
    found = re.search(r'name="token" value="([^"]+)"', line.getresponse().read().decode())
    assert found

    def press_it() -> Stopped | None:
        form = {"Content-Type": "application/x-www-form-urlencoded"}
        line.request("POST", "/stop", f"token={found[1]}", form)
        line.getresponse().read()
        line.close()
        server.shutdown()
        server.server_close()
        return served.stopped

    return press_it


class _Room:
    """A home, the station's own folder and a run's files."""

    def __init__(self, folder: Path, station: StationFile) -> None:
        folder.mkdir(parents=True)
        self.folder, self.station, self.id = folder, station, station.station.id
        self.home = Home(folder / "home")
        self.home.path.mkdir()
        (folder / "database").mkdir()
        self.environment = {
            "MIMUCAL_HOME": str(folder / "home"),
            "MIMUCAL_STATION": str(folder / "side"),
            "MIMUCAL_DATABASE": f"sqlite:///{folder / 'database' / 'catalog.sqlite'}",
            "PREFECT_API_URL": "http://127.0.0.1:1/api",  # nobody answers there
        }
        os.environ["MIMUCAL_STATION"] = self.environment["MIMUCAL_STATION"]
        for name, content in (("station", station), ("procedure", procedure())):
            (folder / f"{name}.json").write_text(content.model_dump_json(), encoding="utf-8")

    def wait_for_readings(self, run: BaseProcess) -> None:
        end_s = time.monotonic() + START_S
        while not any(each.stat().st_size for each in self._recordings()):
            if time.monotonic() > end_s or not run.is_alive():
                raise Unusable(f"{self.folder}: the run did not begin: {self.log()}")
            time.sleep(0.02)

    def log(self) -> str:
        return (self.folder / "run.log").read_text(encoding="utf-8")

    @contextmanager
    def without(self, down: str) -> Iterator[None]:
        """The block while something is away."""
        if down == "the run hangs":
            (self.folder / HANGS).touch()
            end_s = time.monotonic() + 5.0
            while not (self.folder / f"{HANGS}-now").exists() and time.monotonic() < end_s:
                time.sleep(0.01)
            yield
            return
        away = {"home": "home", "database": "database"}.get(down)
        if away is None:
            yield
            return
        (self.folder / away).rename(self.folder / "away")
        try:
            yield
        finally:
            (self.folder / "away").rename(self.folder / away)

    def faults(self, way: str, run: BaseProcess, stopped: Stopped | None) -> Iterator[str]:
        """What is not as it must be, after the run's process has ended."""
        if run.is_alive():
            yield "the run's process has not ended"
        state, _ = table_and_watchdog(self.station)
        if any(axis.is_moving for axis in state.axes):
            yield "the table still turns"
        if stopped is not None and not stopped.at_rest:
            yield f"the stop did not confirm: {stopped.fault}"
        if way in ("command", "page", "button") and stopped is None:
            yield "the stop said nothing"
        yield from self._left()
        is_done = run.exitcode == 0  # the press came when everything was measured
        if not is_done and not any(self._is_readable(each) for each in self._recordings()):
            yield "no recording is left"

    def _left(self) -> Iterator[str]:
        """What says that something runs."""
        if is_held(self.id, self.home) or request_in(self.home.locks, self.id):
            yield "a lock or a request is left"
        end_dead_statuses(self.home)
        for status, dead in statuses(self.home):
            if status.state not in ENDED or dead:
                yield f"the status says {status.state}"

    def _recordings(self) -> list[Path]:
        return sorted((self.folder / "side" / "acquiring").glob("*.mcap"))

    def _is_readable(self, file: Path) -> bool:
        try:
            return len(read_mcap(file, salvage=True).imu) > 0
        except Unusable:
            return False

    def goes_on(self) -> bool:
        """Whether the run, where it was not whole, goes on to its end."""
        if not self._recordings():
            return True
        run = begin(self.folder, self.environment, resume=True)
        run.join(GOES_ON_S)
        run.kill()
        return run.exitcode == 0 and not self._recordings()
