"""A panel of shares over visibility: both axes, curves, and rates with their intervals."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log

from tasks.explain.report.svg import GREY, INK, PALE, label, line, path
from tests.proof.trial.table import Rate

LOWEST, HIGHEST = 2.0, 200.0  # z that a panel shows
POINTS = 60  # of a curve


@dataclass(frozen=True)
class Panel:
    """Where it sits, in the picture's own units: share 1 is at `top`, 0 at top + height."""

    left: float
    top: float
    width: float
    height: float

    def x(self, z: float) -> float:
        """Where a z is, logarithmic; what is beyond the ends is at the end."""
        place = log(min(max(z, LOWEST), HIGHEST) / LOWEST) / log(HIGHEST / LOWEST)
        return self.left + place * self.width

    def y(self, share: float) -> float:
        return self.top + self.height * (1.0 - share)

    def frame(self, size: float = 11, words: bool = True) -> list[str]:
        """Lines at 0, 50 and 100 %, ticks at z 3, 10, 30 and 100; words beside the shares."""
        parts = []
        for share in (0.0, 0.5, 1.0):
            parts.append(
                line(self.left, self.y(share), self.left + self.width, self.y(share), PALE)
            )
            if words:
                at = self.y(share) + size / 3
                parts.append(label(self.left - 5, at, f"{100 * share:.0f} %", size, "end", GREY))
        for z in (3, 10, 30, 100):
            foot = self.top + self.height
            parts.append(line(self.x(z), foot, self.x(z), foot + 3, GREY))
        parts.append(line(self.left, self.y(0), self.left + self.width, self.y(0), GREY))
        return parts

    def numbers(self, y: float, size: float = 11) -> list[str]:
        """The z of the ticks, at a base line y."""
        return [label(self.x(z), y, f"{z}", size, "middle", GREY) for z in (3, 10, 30, 100)]

    def curve(self, share: Callable[[float], float], colour: str, width: float = 1.6) -> str:
        """A share as a function of z."""
        course = (LOWEST * (HIGHEST / LOWEST) ** (i / POINTS) for i in range(POINTS + 1))
        return path([(self.x(z), self.y(share(z))) for z in course], colour, width)

    def series(
        self, rates: list[tuple[float, Rate]], colour: str, shift: float = 0.0, radius: float = 3.0
    ) -> list[str]:
        """Rates by z, joined, with their 95 % intervals; shifted beside others of the same z."""
        parts, joined = [], []
        for z, rate in rates:
            if rate.share is None or rate.interval is None:
                continue
            x, y = self.x(z) + shift, self.y(rate.share)
            low, high = rate.interval
            parts.append(line(x, self.y(low), x, self.y(high), colour, 1.3))
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{colour}"/>')
            joined.append((x, y))
        return [path(joined, colour, 1.0), *parts] if joined else []

    def title(self, words: str, size: float = 12) -> str:
        return label(self.left, self.top - 8, words, size, bold=True, colour=INK)
