"""A controller of tables that takes `:mode:pos 1`, `:dem:pos 1,45`, `:read:pos? 1;rate? 1`.

Written from how public programs talk to such tables: short and long words in any case, commands
without an answer, a status register that is asked for errors, an interlock for each axis, limits
for each mode, angles within a turn that are reached the short way. One that comes too soon after
the one before is not taken. With a header, every line has an answer and every answer the header.
"""

from collections.abc import Callable

from tests.tasks.station.makers.motion import Axes

WORDS = ("mode", "demand", "limit", "interlock", "read", "position", "rate", "acceleration")
MODES = ("off", "position", "rate")
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
            for mode in MODES
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
            case ["mode", mode] if mode in MODES:
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
