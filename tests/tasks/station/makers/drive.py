"""A drive that turns at a constant rate to where it was sent, in wall time."""

import time


class Drive:
    """Angle and rate in deg and deg/s."""

    def __init__(self) -> None:
        self._began_s = time.monotonic()
        self._from, self._rate, self._end = 0.0, 0.0, None

    def _go(self, rate: float, end: float | None) -> None:
        self._from, self._began_s, self._rate, self._end = self.angle, time.monotonic(), rate, end

    def move(self, angle: float, speed: float) -> None:
        self._go(speed if angle >= self.angle else -speed, angle)

    def spin(self, rate: float) -> None:
        self._go(rate, None)

    def halt(self) -> None:
        self._go(0.0, None)

    @property
    def angle(self) -> float:
        gone = self._from + self._rate * (time.monotonic() - self._began_s)
        if self._end is None:
            return gone
        return min(gone, self._end) if self._rate > 0 else max(gone, self._end)

    @property
    def rate(self) -> float:
        return 0.0 if self._end is not None and self.angle == self._end else self._rate

    @property
    def is_there(self) -> bool:
        return self._end is None or self.angle == self._end
