"""Effects that act on the rows of the log, behind the sensors."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect
from tests.proof.plant.seeds import generator

TRIADS = {"gyro": slice(0, 3), "accel": slice(3, 6)}


@dataclass(frozen=True)
class Rows:
    """stamp: (n,) s. readings: (6, n) rad/s and m/s². step: (6,), of the codes."""

    stamp: np.ndarray
    readings: np.ndarray
    step: np.ndarray


class Logged(Effect):
    """An effect on the rows. form: its name in a case. before_codes: acts before rounding."""

    form: ClassVar[str]
    before_codes: ClassVar[bool] = False
    sized: ClassVar[tuple[str, ...]] = ()

    def logged(self, rows: Rows) -> Rows:
        """The rows as they are written."""
        raise NotImplementedError

    def rng(self) -> np.random.Generator:
        """Random numbers of the log itself."""
        return generator(self.setting.case.seed, f"log {self.name}")


def some_triad(rng: np.random.Generator) -> str:
    return str(rng.choice(list(TRIADS)))
