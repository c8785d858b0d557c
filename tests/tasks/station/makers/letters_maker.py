"""A controller of tables that takes HOM, SRV, ACL, VEL, PPO, JOG and STO, and ends with a prompt.

Written from how public programs talk to such tables: three letters and the axis, a carriage return;
every line is answered, with a number where it asks for one and with the prompt alone where it was
taken. An error stands as ?NN before the prompt. Angles are counts of a counter that turns over.
"""

from tests.tasks.station.makers.motion import Axes

COUNT_DEG = 1e-4
COUNTER_BITS = 26
HOMES_S = 2.0
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
