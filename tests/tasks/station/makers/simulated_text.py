"""A station behind a controller of text, in simulated time: late and lost answers, a busy computer.

The product's own driver talks to the emulated controller through a port in pyserial's place.
"""

import asyncio
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import pytest

from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station.acquisition import Acquired, NewRecording, RunRequest, run
from tasks.station.clock import wall_s
from tasks.station.connected_station import Bench
from tasks.station.drivers.table import DescribedTable
from tasks.station.drivers.text_device import TextBackend, TextLink
from tasks.station.drivers.unit import UnitDriver
from tasks.station.ports import Climate
from tasks.station.virtual.config import AXIS_STATUS, MODES, VirtualStation, station_file
from tasks.station.virtual.simulation import Simulation
from tasks.station.virtual.table import Profile, VirtualTable
from tests.simulated_time import run_simulated
from tests.tasks.station.in_memory import InMemoryLine

SLICE_S = 0.1  # in which time passes where nobody asks
STEPS_S = 1000


class Controller(Protocol):
    """terminator: what ends a line that it takes."""

    terminator: bytes

    def hear(self, line: bytes) -> bytes: ...


@dataclass
class Line:
    """What is wrong with the line and the computer.

    latency_s: an exchange takes twice as long at most. lost: the share of answers that never come.
    busy: the share of exchanges in which the computer does something else, for up to busy_s.
    """

    baudrate: int = 0
    latency_s: float = 0.004
    lost: float = 0.0
    busy: float = 0.0
    busy_s: float = 1.5
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(46))

    def delays_s(self) -> tuple[float, float]:
        """Before the controller hears a line, and after it answered."""
        before, after = self.rng.uniform(0.0, self.latency_s, 2)
        late = self.rng.uniform(0.0, self.busy_s, 2) * (self.rng.uniform(size=2) < self.busy / 2)
        return before + late[0], after + late[1]


class EmulatedPort:
    """In the place of a port of pyserial; `took_s` is what reading and writing would have taken."""

    def __init__(self, controller: Controller, line: Line, timeout_s: float) -> None:
        self._controller, self._line, self._timeout_s = controller, line, timeout_s
        self._heard, self._answers = b"", b""
        self.took_s = 0.0

    def write(self, data: bytes) -> None:
        self._take(data)
        *lines, self._heard = (self._heard + data).split(self._controller.terminator)
        for each in lines:
            answer = self._controller.hear(each)
            if self._line.rng.uniform() >= self._line.lost:
                self._answers += answer

    def read_until(self, end: bytes, most: int) -> bytes:
        place = self._answers.find(end)
        if place < 0:
            self.took_s += self._timeout_s
            return self._answers
        answer, self._answers = self._answers[: place + len(end)], self._answers[place + len(end) :]
        self._take(answer)
        return answer

    def reset_input_buffer(self) -> None:
        self._answers = b""

    def close(self) -> None:
        self._answers = b""

    def _take(self, data: bytes) -> None:
        if self._line.baudrate:
            self.took_s += 10 * len(data) / self._line.baudrate


class EmulatedLink(TextLink):
    """A link whose exchanges take simulated time, in the loop instead of a thread."""

    def __init__(self, described: Any, line: Line, moved: Callable[[], None]) -> None:
        super().__init__(described)
        self._line, self._moved = line, moved

    async def _in_thread(self, line: str, is_answered: bool) -> str | None:
        before_s, after_s = self._line.delays_s()
        await asyncio.sleep(before_s)
        self._moved()
        port = self._connected()
        began_s = port.took_s
        answer = self._exchange(line, is_answered)
        await asyncio.sleep(after_s + port.took_s - began_s)
        return answer


# Axes that turn as the virtual table's do, by what a controller's language tells them.


PIECES = 200  # of a period


class Axes:
    """The drives of a table in the units of its controllers, deg and deg/s; `sin` turns to and fro.

    Angles run on past whole turns.
    """

    def __init__(self, table: VirtualTable) -> None:
        self.table = table
        self.count = len(table.drives)

    def angle(self, axis: int) -> float:
        """What the encoder shows."""
        counts = int(self.table.counts(self.table.angle)[axis])
        return 360.0 * counts / self.table.design.counts_per_turn

    def rate(self, axis: int) -> float:
        return math.degrees(self.table.rate[axis])

    def is_moving(self, axis: int) -> bool:
        return bool(self.table.axis_status(axis) & AXIS_STATUS["moving"])

    def go(self, axis: int, angle: float, rate: float, acceleration: float) -> None:
        self.table.drives[axis].target_angle = math.radians(angle)
        self._start(axis, "angle", rate, acceleration)

    def turn(self, axis: int, rate: float, acceleration: float) -> None:
        self._start(axis, "rate", rate, acceleration)

    def swing(self, axis: int, amplitude: float, frequency: float, cycles: int) -> None:
        """A sinusoid about where it stands, drawn as pieces of constant acceleration."""
        drive, now = self.table.drives[axis], self.table.now
        start = float(drive.profile.at(np.array([now]))[0][0])
        t = np.linspace(0.0, cycles / frequency, PIECES * cycles + 1)
        rate = math.radians(amplitude) * 2.0 * np.pi * frequency * np.cos(2 * np.pi * frequency * t)
        rate *= np.minimum(1.0, 4.0 * np.minimum(t, t[-1] - t) * frequency)  # in and out
        change = np.append(np.diff(rate) / np.diff(t), 0.0)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t))])
        drive.profile = Profile(now + t, start + turned, rate, change)
        drive.mode, drive.setpoint = MODES["rate"], 0.0

    def halt(self, axis: int) -> None:
        self.table.command(axis, MODES["stop"])

    def _start(self, axis: int, mode: str, rate: float, acceleration: float) -> None:
        drive = self.table.drives[axis]
        drive.target_rate = math.radians(rate)
        drive.acceleration_limit = math.radians(acceleration)
        self.table.command(axis, MODES[mode])


class Air:
    """A thermometer that reports no time."""

    async def climate(self) -> Climate:
        return Climate(float("nan"), 20.0, 45.0, 5.0, float("nan"))

    async def set_temperature(self, degc: float) -> None:
        raise NotImplementedError


class EmulatedStation:
    """One run on a table behind a controller; `make` makes it of the table's axes and a clock.

    table: that of a station file.
    """

    def __init__(
        self,
        config: VirtualStation,
        table: dict[str, Any],
        make: Callable[[Axes, Callable[[], float]], Controller],
        line: Line,
    ) -> None:
        self.simulation = Simulation(config)
        own = station_file(config, 1.0, "in-memory", 1, 1).model_dump()
        own["fixture"] = "by_hand"
        self.file = StationFile.model_validate(own | {"table": table})
        self.controller = make(Axes(self.simulation.table), lambda: self.simulation.table.now)
        self._line, self._unit = line, InMemoryLine()

    def _moved(self) -> None:
        """Time passes up to now."""
        while (steps := int(wall_s() * 1000) - self.simulation.table.steps) > 0:
            if sent := self.simulation.advance(min(steps, STEPS_S)):
                self._unit.send(b"".join(sent))

    def acquire(self, procedure: Procedure, sink: Any) -> Acquired:
        """The run of a procedure. Raises as `tasks.station.acquisition.acquire` does."""
        recording = NewRecording(self.file, sink, "emulated")
        request = RunRequest(self.file, procedure, (recording,), lambda progress: None)
        with self._ports():
            (acquired,) = run_simulated(self._run(request))
        return acquired

    @contextmanager
    def _ports(self) -> Iterator[None]:
        def opened(url: str, timeout: float, **_: Any) -> EmulatedPort:
            return EmulatedPort(self.controller, self._line, timeout)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("serial.serial_for_url", opened)
            yield

    async def _run(self, request: RunRequest) -> tuple[Acquired, ...]:
        described: Any = self.file.table
        names = tuple(axis.name for axis in self.file.station.table_axes or ())
        link = EmulatedLink(described, self._line, self._moved)
        table = DescribedTable(described, TextBackend(described, link, len(names)), names)
        unit = UnitDriver(self.file.unit_link, self._unit)
        bench = Bench(table, Air(), None, (unit,), beside=_here)
        keeper = asyncio.ensure_future(self._keep())
        try:
            return await run(request, bench)
        finally:
            await asyncio.sleep(3.0)  # for the table to come to rest
            self._moved()
            keeper.cancel()
            await asyncio.gather(keeper, return_exceptions=True)

    async def _keep(self) -> None:
        while True:
            self._moved()
            await asyncio.sleep(SLICE_S)


async def _here(work: Any) -> None:
    await work


# A controller of tables that takes `:mode:pos 1`, `:dem:pos 1,45`, `:read:pos? 1;rate? 1`.
#
# Written from how public programs talk to such tables: short and long words in any case, commands
# without an answer, a status register that is asked for errors, an interlock for each axis, limits
# for each mode, angles within a turn that are reached the short way. One that comes too soon after
# the one before is not taken. With a header, every line has an answer and every answer the header.


WORDS = ("mode", "demand", "limit", "interlock", "read", "position", "rate", "acceleration")
CONTROL_MODES = ("off", "position", "rate")
COMMAND_ERROR, EXECUTION_ERROR = 32, 16  # bits of the event status register, IEEE 488.2


class ColonMaker:
    """now: seconds, by which a line is too soon. `refused` has what it did not understand."""

    terminator = b"\n"

    def __init__(
        self, axes: Axes, now: Callable[[], float], needs_s: float = 0.0, header: str = ""
    ) -> None:
        self._axes, self._now, self._needs_s, self._header = axes, now, needs_s, header
        self._taken_s = -1e9
        self.is_closed = [False] * axes.count
        self.mode = ["off"] * axes.count
        self.limits = {
            (what, mode, axis): most
            for what, most in (("rate", 400.0), ("acceleration", 200.0))
            for mode in CONTROL_MODES
            for axis in range(axes.count)
        }
        self.errors = 0
        self.refused: list[str] = []

    def hear(self, line: bytes) -> bytes:
        """The answer to a line; nothing where it has none."""
        text = line.decode("ascii", "replace").strip()
        if "?" in text:
            return self._written(";".join(self._asked(text)))
        if self._now() - self._taken_s < self._needs_s - 1e-6:
            self._wrong(text, EXECUTION_ERROR)
        else:
            self._taken_s = self._now()
            try:
                self._commanded(text)
            except (ValueError, KeyError, IndexError):
                self._wrong(text, COMMAND_ERROR)
        return self._written("") if self._header else b""

    def _written(self, text: str) -> bytes:
        return f"{self._header}{text}\r\n".encode()

    def _wrong(self, text: str, error: int) -> None:
        self.errors |= error
        self.refused.append(text)

    def _asked(self, text: str) -> list[str]:
        if text.lower() == "*idn?":
            return ["EMULATED,COLON-3,0001,1.0"]
        if text.lower() == "*esr?":
            errors, self.errors = self.errors, 0
            return [str(errors)]
        answers, path = [], ""
        for part in text.split(";"):
            head, _, number = part.partition("? ")
            *above, last = head.strip(":").split(":")
            path = above[0] if above else path
            axis = int(number) - 1
            match _whole(path or last), _whole(last):
                case "read", "position":
                    answers.append(f"{self._axes.angle(axis) % 360.0:.4f}")
                case "read", "rate":
                    answers.append(f"{self._axes.rate(axis):.4f}")
                case "interlock", _:
                    answers.append("Closed" if self.is_closed[axis] else "Open")
                case _:
                    self._wrong(text, COMMAND_ERROR)
        return answers

    def _commanded(self, text: str) -> None:
        head, _, rest = text.partition(" ")
        words, values = [_whole(word) for word in head.strip(":").split(":")], rest.split(",")
        match words:
            case ["interlock", "reset"]:
                self.errors = 0
            case ["interlock", "close" | "open" as state]:
                self.is_closed[int(values[0]) - 1] = state == "close"
                if state == "open":
                    self._switch(int(values[0]) - 1, "off")
            case ["mode", mode] if mode in CONTROL_MODES:
                self._switch(int(values[0]) - 1, mode)
            case ["limit", what] if what in ("rate", "acceleration"):
                self._limit(what, _whole(values[0]), int(values[1]) - 1, float(values[2]))
            case ["demand", what]:
                self._demand(what, int(values[0]) - 1, float(values[1]))
            case _:
                raise ValueError(text)

    def _switch(self, axis: int, mode: str) -> None:
        if mode != "off" and not self.is_closed[axis]:
            raise ValueError("interlock open")
        if mode != self.mode[axis]:
            self._axes.halt(axis)
        self.mode[axis] = mode

    def _limit(self, what: str, mode: str, axis: int, most: float) -> None:
        if (what, mode, axis) not in self.limits or most <= 0.0:
            raise ValueError("no such limit")
        self.limits[what, mode, axis] = most

    def _demand(self, what: str, axis: int, value: float) -> None:
        if self.mode[axis] != what:
            raise ValueError("another mode")
        acceleration = self.limits["acceleration", what, axis]
        if what == "rate":
            self._axes.turn(axis, value, acceleration)
            return
        if not 0.0 <= value <= 360.0:
            raise ValueError("not within a turn")
        now = self._axes.angle(axis)
        away = (value - now + 180.0) % 360.0 - 180.0  # half a turn goes backwards
        self._axes.go(axis, now + away, self.limits["rate", what, axis], acceleration)


def _whole(word: str) -> str:
    """A word from its first three or more letters, or as it is."""
    word = word.strip().lower()
    return next((each for each in WORDS if len(word) > 2 and each.startswith(word)), word)


# A controller of tables that takes HOM, SRV, ACL, VEL, PPO, JOG and STO, and ends with a prompt.
#
# Written from how public programs talk to such tables: three letters, the axis, a carriage return;
# every line is answered, with a number where it asks for one and with the prompt alone where it was
# taken. An error stands as ?NN before the prompt. Angles are counts of a counter that turns over.


COUNT_DEG = 1e-4
COUNTER_BITS = 26
UNKNOWN, NOT_READY, NO_NUMBER = 1, 2, 3


class LettersMaker:
    """`refused` has what it did not understand. The prompt stands at the end of every answer."""

    terminator = b"\r"
    prompt = "\r\n>"

    def __init__(self, axes: Axes, names: str = "ABC") -> None:
        self._axes, self._names = axes, names
        self.speed = [10.0] * axes.count
        self.acceleration = [10.0] * axes.count
        self.is_on = [False] * axes.count
        self.is_homed = [False] * axes.count
        self.refused: list[str] = []

    def hear(self, line: bytes) -> bytes:
        """The answer to a line, its prompt with it."""
        text = line.decode("ascii", "replace").strip()
        answer = self._answer(text)
        if answer.startswith("?"):
            self.refused.append(text)
        return f"{answer}{self.prompt}".encode()

    def _answer(self, text: str) -> str:
        match text.split():
            case [command, name, *numbers] if name in self._names:
                axis = self._names.index(name)
            case _:
                return f"?{UNKNOWN:02d}"
        try:
            value = None if not numbers or "," in numbers[0] else float(numbers[0])
        except ValueError:
            return f"?{NO_NUMBER:02d}"
        if command == "SIN":
            return self._swung(axis, numbers)
        return (
            self._asked(command, axis) if "?" in command else self._commanded(command, axis, value)
        )

    def _swung(self, axis: int, numbers: list[str]) -> str:
        if not self.is_on[axis] or not numbers:
            return f"?{NOT_READY:02d}"
        amplitude, frequency, cycles = numbers[0].split(",")
        self._axes.swing(axis, float(amplitude), float(frequency), int(cycles))
        return ""

    def _asked(self, command: str, axis: int) -> str:
        match command:
            case "PPO?":
                counts, half = round(self._axes.angle(axis) / COUNT_DEG), 2 ** (COUNTER_BITS - 1)
                return str((counts + half) % (2 * half) - half)
            case "VEL?":
                return f"{self._axes.rate(axis):.4f}"
            case "STA?":
                return f"{self.is_homed[axis] << 1 | self.is_on[axis]:02X}"
        return f"?{UNKNOWN:02d}"

    def _commanded(self, command: str, axis: int, value: float | None) -> str:
        if command == "STO":
            self._axes.halt(axis)
            return ""
        if command == "HOM":
            if not self.is_on[axis]:
                return f"?{NOT_READY:02d}"
            self._axes.go(axis, 0.0, self.speed[axis], self.acceleration[axis])
            self.is_homed[axis] = True
            return ""
        if value is None:
            return f"?{NO_NUMBER:02d}"
        match command:
            case "SRV":
                self.is_on[axis] = value == 1
                if not self.is_on[axis]:
                    self._axes.halt(axis)
            case "ACL":
                self.acceleration[axis] = value
            case "VEL":
                self.speed[axis] = value
            case "PPO" if self.is_homed[axis]:
                self._axes.go(axis, value * COUNT_DEG, self.speed[axis], self.acceleration[axis])
            case "JOG" if self.is_on[axis]:
                self._axes.turn(axis, value, self.acceleration[axis])
            case _:
                return f"?{NOT_READY:02d}"
        return ""
