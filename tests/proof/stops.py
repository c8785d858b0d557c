"""When a table came to rest, by the gyros of the unit on it: they know nothing of who stops it."""

import asyncio
import http.client
import importlib
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any
from unittest.mock import patch
from urllib.parse import urlsplit

import numpy as np

from flows.station_page import StationPage, page_server
from schemas.base import BrokenOff, Unusable
from schemas.orders import AcquireOrder
from schemas.procedure import Procedure
from schemas.recording import ENDED
from schemas.station import StationFile, Stopped
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.stations import end_dead_statuses, is_held, request_in, statuses
from tasks.stages.stop import stop_station
from tasks.station.acquisition import Sequencer
from tasks.station.virtual.config import VirtualStation
from tests.proof.kills import seeds
from tests.proof.study import Count, Out, Seed, Write, folder_of, hold, table
from tests.proof.virtual_runs import FRAME, short_procedure
from tests.tasks.station.over_sockets import table_and_watchdog

MOVES_RAD_S = np.radians(2.0)  # above bias, noise and Earth's rate
LOOKED_AT = 3  # frames, whose median counts


class Observed:
    """Reads a unit's line, and notes when it turned last (s, monotonic). lsb: of gyros, rad/s."""

    def __init__(self, station: StationFile, lsb: float) -> None:
        unit = urlsplit(station.unit_link.url)
        self._line = socket.create_connection((str(unit.hostname), int(unit.port or 0)), 10.0)
        self._lsb = lsb
        self.moved_s = self.read_s = 0.0
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        data = b""
        try:
            while part := self._line.recv(65536):
                data += part
                whole = len(data) // (LOOKED_AT * FRAME.size) * (LOOKED_AT * FRAME.size)
                frames, data = data[:whole], data[whole:]
                counts = np.array([frame[3:6] for frame in FRAME.iter_unpack(frames)])
                if len(counts):
                    rates = np.abs(np.median(counts.reshape(-1, LOOKED_AT, 3), axis=1)) * self._lsb
                    self.read_s = time.monotonic()
                    # of frames that came together the last ones tell
                    if rates[-1].max() > MOVES_RAD_S:
                        self.moved_s = self.read_s
        except OSError:
            pass  # hung up

    @property
    def turns(self) -> bool:
        return self.read_s - self.moved_s < 0.1

    def close(self) -> None:
        """Read no more."""
        self._line.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._line.close()


# A run and a virtual station in processes of their own, forked: they begin at once.

HANG_S = 6.0
HANGS = "hangs"  # a file in the station's folder, from whose appearing on the run's loop stands


IMPORTED = (
    "flows.acquisition_view", "tasks.stages.acquire", "tasks.station.virtual.servers",
    "pymodbus.client", "serial", "storage.catalogue.runs", "alembic.command", "fluent.runtime",
    "tasks.rendering.page", "jinja2",
)  # fmt: skip


def preload() -> None:
    """Import once what every fork needs."""
    for name in IMPORTED:
        importlib.import_module(name)


@contextmanager
def station_apart(config: VirtualStation, speed: float) -> Iterator[StationFile]:
    """A running virtual station."""
    context = get_context("fork")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(config, speed, there), daemon=True)
    process.start()
    try:
        yield here.recv()
    finally:
        process.kill()
        process.join()


def _serve(config: VirtualStation, speed: float, ready: Any) -> None:
    from tasks.station.virtual.servers import serve

    asyncio.run(serve(config, speed=speed, ready=ready.send))


def begin(folder: Path, environment: dict[str, str], resume: bool = False) -> BaseProcess:
    """An acquisition by folder/station.json and folder/procedure.json."""
    process = get_context("fork").Process(target=_acquire, args=(folder, environment, resume))
    process.start()
    return process


def _acquire(folder: Path, environment: dict[str, str], resume: bool) -> None:
    from flows import execute

    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(each, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.update(environment)
    order = AcquireOrder(
        station=str(folder / "station.json"), procedure=str(folder / "procedure.json"),
        attended=False, resume=resume,
    )  # fmt: skip
    with (folder / "run.log").open("a") as log, patch.object(Sequencer, "_watch", _hanging(folder)):
        sys.stderr = sys.stdout = log
        try:
            execute.acquire(order)
        except (BrokenOff, Unusable) as end:
            log.write(f"{end}\n")
            log.flush()
            os._exit(1)
        except KeyboardInterrupt:
            log.write("Ctrl-C\n")
            log.flush()
            os._exit(1)
        log.flush()
    os._exit(0)


def _hanging(folder: Path) -> Callable[[Sequencer], Coroutine[Any, Any, Any]]:
    """The look at the table, which hangs once where the folder says so."""
    watch = Sequencer._watch

    async def look(self: Sequencer) -> Any:
        with suppress(FileNotFoundError):
            (folder / HANGS).unlink()
            (folder / f"{HANGS}-now").touch()
            time.sleep(HANG_S)
        return await watch(self)

    return look


# One press at a random moment, and what it left.

WAYS = ("command", "button", "page", "SIGTERM", "SIGTERM twice", "Ctrl-C", "kill -9")
DOWN = ("nothing", "home", "database", "Prefect", "the run hangs")
BY = "Li"
BOUND_S = 2.0  # from the press until the table is at rest
WATCHDOG_S = 5.0  # of the station's table, and then the ramp
RAMP_S = 3.5  # from 300 deg/s with 120 deg/s2, and a margin
START_S, END_S, GOES_ON_S = 90.0, 60.0, 400.0  # of a machine that is busy with other work
LONGEST_S = 60.0  # station time after the first move at which the press comes at the latest
SOURCE = Path(__file__).parents[2]


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


# Many presses, and the page of them.

AT_ONCE = 4
SPEEDS = (1.0, 5.0, 2.0, 20.0)  # of the stations, which take turns
RESUMED_EVERY = 8  # stops, after one of which it is tried whether the run goes on
COLUMNS = (
    "seed", "by", "down", "clock", "turning", "at rest (s)", "confirmed (s)", "went on", "wrong",
)  # fmt: skip


def stops(count: Count = 100, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Stops at random moments, with each part down in turn."""
    folder = folder_of("stops", out)
    hold("stops", seeds(count, seed), partial(_one, folder=folder), as_markdown, out, write=write,
         at_once=AT_ONCE, faults=_wrong)  # fmt: skip


def _wrong(one: Pressed) -> Iterator[str]:
    yield from one.faults
    if one.resumed is False:
        yield f"seed {one.seed}: the run did not go on"


def _one(seed: int, folder: Path) -> Pressed:
    preload()
    folder = folder / f"{seed:03d}"
    shutil.rmtree(folder, ignore_errors=True)
    speed = SPEEDS[seed % len(SPEEDS)]
    config = VirtualStation(id=f"STOPS-{seed}")
    with station_apart(config, speed) as station:
        return press(
            seed, folder, station, speed, config.unit.gyro.lsb, resume=seed % RESUMED_EVERY == 3
        )


def summary(pressed: Sequence[Pressed]) -> str:
    """One sentence."""
    wrong = sum(bool(each.faults) or each.resumed is False for each in pressed)
    stopped = [each.rest_s for each in pressed if each.way != "kill -9"]
    killed = [each.rest_s for each in pressed if each.way == "kill -9"]
    again = [each.resumed for each in pressed if each.resumed is not None]
    turning = sum(each.turning for each in pressed)
    return (
        f"{len(pressed)} stops at random moments, {turning} of them with the table turning: "
        f"{wrong} wrong; the table was at rest at most {max(stopped, default=0.0):.2f} s after the "
        f"press, and at most {max(killed, default=0.0):.2f} s after the run's process was killed; "
        f"{sum(map(bool, again))} of the {len(again)} runs with which it was tried went on to "
        "their end"
    )


def as_markdown(pressed: Sequence[Pressed]) -> str:
    """The summary, how it was held, and a row for each press."""
    rows = [
        (
            each.seed, each.way, each.down, f"{each.speed:g}", "yes" if each.turning else "",
            f"{each.rest_s:.2f}", f"{each.confirmed_s:.2f}",
            {True: "yes", False: "NO", None: ""}[each.resumed], "; ".join(each.faults),
        )
        for each in sorted(pressed, key=lambda each: each.seed)
    ]  # fmt: skip
    return "\n".join([
        "# Stops",
        "",
        f"{summary(pressed)}.",
        "",
        "Each on a virtual station of its own, while a run turns its table at up to 300 °/s. The",
        "station is pressed to stop by a command in a process of its own, by the function behind",
        "the button of the pages, on the station's own page, by signals, or its run is killed; at",
        "that moment nothing is down, or the home or the database is renamed away, Prefect's",
        "address leads nowhere, or the run's own event loop hangs. Whether the table turns is read",
        "from the gyros of its unit (wall time; below 2 °/s is at rest), and must be over within",
        f"{BOUND_S:g} s, or after a kill within the watchdog's {WATCHDOG_S:g} s and a ramp of at",
        f"most {RAMP_S:g} s. Clock 1 is real time: the ramps are those of a table that brakes with",
        "400 °/s² at a quick stop; at clock 5 and 20 they are shorter by that factor. Afterwards a",
        "recording is left and can be read, no lock or request is left, and no status says that",
        f"anything runs. After one in {RESUMED_EVERY} stops the run goes on to its end.",
        "",
        *table(COLUMNS, rows),
        "",
    ])  # fmt: skip
