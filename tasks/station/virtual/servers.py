"""The virtual station on the network: Modbus/TCP, the unit's stream, and the clock."""

import asyncio
import logging
import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.clock import wall_s
from tasks.station.virtual.config import (
    MOUNT_ANSWER,
    MOUNT_REQUEST,
    REFUSAL,
    SERIAL_ANSWER,
    SERIAL_REQUEST,
    STEP_S,
    VirtualStation,
    station_file,
)
from tasks.station.virtual.faults import Condition, StationFault
from tasks.station.virtual.registers import Controller, ControllerServer
from tasks.station.virtual.simulation import Simulation

# The virtual station in a process of its own, for demonstrations and tests.
#
# `python -m tasks.station.virtual.servers CONFIG SPEED FAULT...` writes the station file as one
# line of JSON, and ends when standard input closes.

END_S = 5.0


@contextmanager
def running(
    config: VirtualStation, speed: float, faults: Iterable[StationFault] = ()
) -> Iterator[StationFile]:
    """A running station; it ends with the block, or with this process.

    speed: station seconds in a wall second. Raises Unusable with the station's own sentence where
    it cannot start.
    """
    with subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            __name__,
            config.model_dump_json(),
            str(speed),
            *map(str, faults),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for this process, which then ends the station
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            answer = process.stdout.readline()
            if not answer.startswith("{"):
                raise Unusable(
                    answer.strip() or "the virtual station did not start: see its messages"
                )
            yield StationFile.model_validate_json(answer)
        finally:
            process.stdin.close()
            try:
                process.wait(END_S)
            except subprocess.TimeoutExpired:
                process.kill()


async def _serve_until_input_ends(config: str, speed: str, *faults: str) -> None:

    serving = asyncio.ensure_future(
        serve(
            VirtualStation.model_validate_json(config),
            speed=float(speed),
            faults=[StationFault.parse(text) for text in faults],
            ready=lambda station: print(station.model_dump_json(), flush=True),
        )
    )
    input_ended = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    await asyncio.wait((serving, input_ended), return_when=asyncio.FIRST_COMPLETED)
    if serving.done():
        try:
            serving.result()
        except Unusable as error:
            print(error, flush=True)
    serving.cancel()


# The lines of text on a unit's connection: the unit tells its serial number, and another unit is
# mounted by those who send what an operator's hands would do.

LONGEST = 64  # characters of a serial number


async def attend(
    simulation: Simulation,
    place: int,
    lines: asyncio.StreamReader,
    client: asyncio.StreamWriter,
) -> None:
    """Answers each line of a client of the unit at a place, until it hangs up."""
    try:
        while line := await lines.readline():
            answered = answer(simulation, place, line.decode("ascii", "replace").strip())
            if answered is not None:
                client.write(f"{answered}\r\n".encode("ascii", "replace"))
    except (OSError, ValueError):  # it is gone, or sends what is no line
        return


def answer(simulation: Simulation, place: int, line: str) -> str | None:
    """What a line is answered with; None for what is no request, and from a unit without supply."""
    if line.startswith(MOUNT_REQUEST):
        unit = line.removeprefix(MOUNT_REQUEST)
        serial, _, seed = unit.partition(",")
        if not (0 < len(serial) <= LONGEST and serial.isprintable() and seed.isdecimal()):
            return f"{REFUSAL}send {MOUNT_REQUEST}SERIAL,SEED"
        simulation.mount(place, serial, int(seed))
        return f"{MOUNT_ANSWER}{serial}"
    if line != SERIAL_REQUEST or not simulation.is_supplied:
        return None
    mounted = (simulation.config.unit, *simulation.config.neighbours)[place]
    return f"{SERIAL_ANSWER}{mounted.serial}"


LOG = logging.getLogger("mimucal.station.virtual")
SLICE_WALL_S = 0.005
BREATH_WALL_S = 0.0005  # where it is behind: not 0, for a request takes several turns of the loop
MAX_STEPS = 1000  # in one go: some milliseconds of computing, so that requests are answered
LATE_STATION_S = 0.5  # station time by which the clocks of late clients may differ
SLOWEST = 1.0  # no machine is too slow for real time
FORGET_S = 1.0  # wall time in which a late wait counts e times less
SLOW_S = 3.0  # wall time in which less than half of the station time makes it say so
IDLE_WALL_S = 0.1
IDLE_STEPS = 5 * MAX_STEPS
IDLE_AFTER_S = 1.0  # wall time since the last request
BACKLOG_BYTES = 16_000_000  # a client that reads no more is hung up on


def _send(clients: set[asyncio.StreamWriter], data: bytes) -> None:
    for client in tuple(clients):
        if client.is_closing():
            clients.discard(client)
            continue
        client.write(data)
        if client.transport.get_write_buffer_size() > BACKLOG_BYTES:
            client.transport.abort()


def _suffer(condition: Condition, clients: set[asyncio.StreamWriter], free_since_s: float) -> float:
    """The faults of the computer and of the unit's connection.

    free_since_s: since when (wall time) the computer is not busy, also what is returned: it is so
    for as long as it is busy.
    """
    if condition.busy_s and time.monotonic() - free_since_s > condition.busy_s:
        time.sleep(condition.busy_s)
        free_since_s = time.monotonic()
    if condition.cuts_unit:
        for unit in clients:
            unit.transport.abort()
        clients.clear()
    return free_since_s


class IdleClock:
    """Longer slices of time for a station at which nothing moves and nobody listens.

    Whoever asks wakes it, and is answered once its time is the present one.
    """

    def __init__(self, is_still: Callable[[], bool]) -> None:
        self._is_still = is_still
        self._asked, self._is_present = asyncio.Event(), asyncio.Event()
        self._asked_s = wall_s()

    @property
    def is_idle(self) -> bool:
        return wall_s() - self._asked_s > IDLE_AFTER_S and self._is_still()

    async def wake(self) -> None:
        """Somebody asks."""
        self._asked_s = wall_s()
        self._asked.set()
        await self._is_present.wait()

    async def sleep(self, seconds: float) -> None:
        """Until so many seconds have passed, or somebody asks."""
        self._asked.clear()
        self._is_present.clear()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._asked.wait(), seconds)

    def is_awake(self) -> None:
        """Time is the present one."""
        self._is_present.set()


class Pace:
    """The speed that this machine allows: at most the one that is asked for.

    Of the latest waits the longest counts, and less the longer ago it was.
    """

    def __init__(self, asked: float) -> None:
        self._asked = asked
        self._late_s = self._passed_s = self._made_s = 0.0
        self._has_spoken = False

    @property
    def speed(self) -> float:
        return min(self._asked, max(LATE_STATION_S / max(self._late_s, 1e-6), SLOWEST))

    def note(self, late_s: float, passed_s: float, made_s: float) -> None:
        """How much later than asked a wait ended, the wall time that passed with the work before
        it, and the station time that this work made.
        """
        self._late_s = max(late_s, self._late_s * math.exp(-passed_s / FORGET_S))
        self._passed_s, self._made_s = self._passed_s + passed_s, self._made_s + made_s
        if self._passed_s < SLOW_S:
            return
        given, self._passed_s, self._made_s = self._made_s / self._passed_s, 0.0, 0.0
        if given < self._asked / 2 and not self._has_spoken:
            self._has_spoken = True
            LOG.warning(
                "this machine gives %.1f times real time in place of %g", given, self._asked
            )


async def keep_time(
    simulation: Simulation,
    speed: float,
    send: Callable[[bytes], None],
    watch: Callable[[], None] = lambda: None,
    doze: IdleClock | None = None,
) -> None:
    """Lets station time pass at speed × wall time, slower where the machine cannot keep up: by how
    much it comes late to its own work, its clients come late to theirs, and what a frame waits for
    at them is an error of their clocks of so much times the speed. It says so.

    It ends with the station's power.

    It stands still while a captured sample would be overwritten that a client still wants.

    send: takes the unit's frames as they come. watch: called in every slice of wall time. doze:
    lengthens the slices of an idle station.
    """
    pace, owed, before_s = Pace(speed), 0.0, wall_s()
    while not simulation.condition.is_dead:
        now_s = wall_s()
        owed += (now_s - before_s) * pace.speed / STEP_S
        before_s = now_s
        behind = int(owed)
        is_idle = doze is not None and doze.is_idle
        most = IDLE_STEPS if is_idle else MAX_STEPS
        owed = min(owed, 2.0 * most)
        watch()
        steps = min(behind, most, simulation.table.room())
        owed -= max(steps, 0)
        if steps > 0 and (sent := simulation.advance(steps)):
            send(b"".join(sent))
        if doze is not None:
            doze.is_awake()
            if is_idle:
                await doze.sleep(min(IDLE_WALL_S, IDLE_STEPS * STEP_S / speed))
                continue
        rest_s, began_s = BREATH_WALL_S if behind > steps > 0 else SLICE_WALL_S, wall_s()
        await asyncio.sleep(rest_s)
        end_s = wall_s()
        pace.note(end_s - began_s - rest_s, end_s - now_s, max(steps, 0) * STEP_S)


async def serve(
    config: VirtualStation,
    *,
    host: str = "127.0.0.1",
    modbus_port: int = 0,
    unit_port: int = 0,
    speed: float = 1.0,
    faults: Iterable[StationFault] = (),
    ready: Callable[[StationFile], None],
) -> None:
    """Runs the station until it is cancelled.

    speed: station seconds per wall second. Port 0 chooses a free one; further units have the ports
    after the first. ready is called with what a client needs to connect. Raises Unusable if a port
    is not available or the speed is invalid.
    """
    if not 0.0 < speed < float("inf"):
        raise Unusable(
            f"the station cannot run at speed {speed}: give a number above 0, as 1 or 20"
        )
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs what clients do wrong
    simulation = Simulation(config, faults)
    simulation.advance(1)  # so that the faults of second 0 hold for the first request
    # of the unit, then of its neighbours
    clients: list[set[asyncio.StreamWriter]] = [set() for _ in (0, *config.neighbours)]
    doze = IdleClock(lambda: simulation.is_still and not simulation.faults and not any(clients))
    controller = Controller(simulation, doze.wake)
    modbus = ControllerServer(controller.devices(), address=(host, modbus_port))
    if not await modbus.listen():
        raise Unusable(f"port {modbus_port} of {host} is not available for Modbus: choose another")
    try:
        units = [
            await _unit_server(simulation, place, each, host, unit_port and unit_port + place)
            for place, each in enumerate(clients)
        ]
    except Unusable:
        modbus.close()
        raise
    try:
        ports = (_port(modbus.transport), *map(_port, units))
        ready(station_file(config, speed, host, *ports))

        free_since_s = 0.0

        def watch() -> None:
            nonlocal free_since_s
            controller.watch()
            free_since_s = _suffer(simulation.condition, clients[0], free_since_s)
            for each, data in zip(clients[1:], simulation.neighbours_sent(), strict=True):
                _send(each, data)

        await keep_time(simulation, speed, lambda data: _send(clients[0], data), watch, doze)
    finally:
        modbus.close()
        for unit in units:
            unit.close()
        for client in set.union(*clients):
            client.close()


async def _unit_server(
    simulation: Simulation, place: int, clients: set[asyncio.StreamWriter], host: str, port: int
) -> asyncio.Server:
    """Takes in who wants a unit's frames, and answers the lines that they send."""

    async def take_in(lines: asyncio.StreamReader, client: asyncio.StreamWriter) -> None:
        clients.add(client)
        await attend(simulation, place, lines, client)

    try:
        return await asyncio.start_server(take_in, host, port)
    except OSError as error:
        raise Unusable(
            f"port {port} of {host} is not available for the unit: choose another"
        ) from error


def _port(server: Any) -> int:
    return int(server.sockets[0].getsockname()[1])


if __name__ == "__main__":
    asyncio.run(_serve_until_input_ends(*sys.argv[1:]))
