"""Wall-clock time and station time: how fast the station runs, and its present time.

Wall time is the running event loop's: `wall_s` reads it and `asyncio.sleep` waits for it. Nothing
in this room asks another clock, so a loop whose time is simulated runs a whole procedure without
waiting.
"""

import asyncio
from collections import deque

from schemas.base import Unusable
from tasks.words import message

WINDOW = 200
CLOCK_TIMEOUT_S = 5.0  # wall time for which it may stand still


def wall_s() -> float:
    """Wall time, s; of a loop that is not simulated, that of `time.monotonic`."""
    return asyncio.get_running_loop().time()


class StationClock:
    """Readings of the station's time, each with the wall time it was taken at.

    The station of a laboratory runs at speed 1; a virtual one may run faster, and not evenly.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float]] = deque(maxlen=WINDOW)
        self._moved_wall_s = 0.0
        self.took_s = 0.0  # wall time from question to answer of the last reading

    def update(self, station_s: float, wall_s: float, took_s: float = 0.0) -> None:
        """Take a reading in: it is of a moment in the `took_s` (s) before `wall_s`."""
        self.took_s = took_s
        if not self._readings or station_s != self.station_s:
            self._moved_wall_s = wall_s
        self._readings.append((station_s, wall_s))

    @property
    def station_s(self) -> float:
        """The last station time read, s."""
        return self._readings[-1][0]

    @property
    def speed(self) -> float:
        """Station seconds in a wall second over the last readings; 1 until it is known."""
        if len(self._readings) < 2:
            return 1.0
        (station_0, wall_0), (station_1, wall_1) = self._readings[0], self._readings[-1]
        if station_1 <= station_0 or wall_1 <= wall_0:
            return 1.0
        return (station_1 - station_0) / (wall_1 - wall_0)

    def at(self, wall_s: float) -> float:
        """The station time at a wall time near the last reading, s."""
        station, wall = self._readings[-1]
        return station + (wall_s - wall) * self.speed

    def latest_at(self, wall_s: float) -> float:
        """The latest that the station time can be then, s: read as soon as it was asked for."""
        return self.at(wall_s) + self.took_s * self.speed

    def wall(self, station_s: float, shortest: float, longest: float) -> float:
        """How long a span of station time takes on the wall, s, kept within the bounds."""
        return min(max(station_s / self.speed, shortest), longest)

    def check(self, before_s: float) -> None:
        """Raises Unusable where it went back behind a station time (s) read before, or stands."""
        if self.station_s < before_s:
            raise Unusable(
                f"the station's clock jumped back from {before_s:.3f} s to {self.station_s:.3f} s, "
                f"as after a restart: start the run again",
                message("station-cause.clock"),
            )
        if self._readings[-1][1] - self._moved_wall_s > CLOCK_TIMEOUT_S:
            raise Unusable(
                f"the station's clock has stood at {self.station_s:.3f} s for "
                f"{CLOCK_TIMEOUT_S:g} s: restart the controller",
                message("station-cause.clock"),
            )
