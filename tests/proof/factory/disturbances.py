"""Each part is killed once at a random moment of the play, and started again some seconds later."""

import os
import random
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tests.proof.factory.works import STATIONS, Works

DELAY_S, AWAY_S = (0.0, 6.0), (1.0, 4.0)  # from when it is due to the kill; without it


@dataclass(frozen=True)
class Happened:
    """What was killed, after how many orders, and how long (s) until it answered again."""

    part: str
    after: int
    away_s: float


@dataclass
class _Next:
    part: str
    due: int  # orders that are done
    delay_s: float
    away_s: float
    due_s: float | None = None
    killed_s: float | None = None
    begun: bool = False


class Disturbances:
    """Kills, one at a time; `tick` is called some times a second."""

    def __init__(
        self, works: Works, parts: Sequence[str], total: int, rng: random.Random,
        came_back: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._works, self._came_back, self._total = works, came_back, total
        shuffled = rng.sample(list(parts), len(parts))
        dues = [total * number // (len(parts) + 1) for number in range(len(parts))]
        self._left = [
            _Next(part, due, rng.uniform(*DELAY_S), rng.uniform(*AWAY_S))
            for part, due in zip(shuffled, dues, strict=True)
        ]  # fmt: skip
        self.happened: list[Happened] = []
        self._killed = ("", 0)

    @property
    def is_over(self) -> bool:
        return not self._left

    @property
    def away(self) -> str | None:
        """The part that is away just now."""
        is_away = bool(self._left) and self._left[0].killed_s is not None
        return self._left[0].part if is_away else None

    def tick(self, done: int) -> None:
        """done: orders."""
        if not self._left:
            return
        now_s, turn = time.monotonic(), self._left[0]
        if turn.killed_s is None:
            if turn.due_s is None and done >= turn.due:
                turn.due_s = now_s + turn.delay_s
            if turn.due_s is not None and now_s >= turn.due_s and self._kill(turn.part):
                turn.killed_s = now_s
            elif turn.part == OF_A_RUN and done >= self._total:  # there is no run any more
                del self._left[0]
        elif not turn.begun and now_s >= turn.killed_s + turn.away_s:
            self._begin(turn.part)
            turn.begun = True
        elif turn.begun and self._is_up(turn.part):
            self.happened.append(Happened(turn.part, done, now_s - turn.killed_s))
            self._came_back(turn.part)
            del self._left[0]

    def _kill(self, part: str) -> bool:
        """Whether it was there to be killed."""
        if part == OF_A_RUN:
            running = self._running()
            if not running:
                return False
            self._killed = next(iter(running.items()))
            os.kill(self._killed[1], signal.SIGKILL)
        elif part == "PostgreSQL":
            self._works.database.kill()
        else:
            self._works.parts[part].kill()
        return True

    def _running(self) -> dict[str, int]:
        """The processes of the orders that measure, by the number of the order."""
        asked = "SELECT number, process FROM orders WHERE state = 'running' AND runs = '[]'"
        with self._works.database.connected("mimucal") as connection:
            return dict(connection.execute(asked).fetchall())

    def _begin(self, part: str) -> None:
        if part == OF_A_RUN:
            return
        if part == "PostgreSQL":
            self._works.database.start()
        else:
            self._works.parts[part].begin()

    def _is_up(self, part: str) -> bool:
        if part == OF_A_RUN:  # the order is no longer held by the dead process
            number, process = self._killed
            return self._running().get(number) != process
        return part == "PostgreSQL" or self._works.parts[part].answers()


OF_A_RUN = "a run's own process"
PARTS = (
    OF_A_RUN,
    "PostgreSQL", "Prefect server", "S3", "pages", "mail sink", "dask scheduler", "worker line",
    *(f"worker station-{id_}" for id_ in STATIONS), *STATIONS,
)  # fmt: skip
