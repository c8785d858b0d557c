"""What a recording of the virtual station is made of: a unit, its filters, its clock, a run."""

from dataclasses import dataclass
from functools import cached_property
from itertools import islice, product
from typing import Literal

import numpy as np

from tasks.station.virtual.config import STEP_S, VirtualStation, virtual_station

ProcedureName = Literal["jjf2003", "jjf1536"]
PROCEDURES: tuple[ProcedureName, ...] = ("jjf2003", "jjf1536")
CORNERS_HZ = (15.0, 80.0)
DELAYS_S = (1e-3, 2e-2)
NO_FILTER_HZ = 0.499 / STEP_S  # half the plant's rate, as nearly as a digital filter has it
SEEDS = 20


@dataclass(frozen=True)
class Case:
    """seed: of the unit, its corners and its delay; which of low-pass and delay it has.

    is_loaded: whether the computer that records is busy with other work, too.
    """

    seed: int
    procedure: ProcedureName
    has_low_pass: bool
    has_delay: bool
    is_loaded: bool = False

    @property
    def name(self) -> str:
        parts = [name for name, has in (("low-pass", self.has_low_pass),
                                        ("delay", self.has_delay)) if has]  # fmt: skip
        loaded = "-loaded" if self.is_loaded else ""
        return f"{self.procedure}-{self.seed:02d}-{'+'.join(parts) or 'neither'}{loaded}"

    @property
    def corners_hz(self) -> tuple[float, float] | None:
        """Of gyros and of accelerometers, second-order Butterworth."""
        low, high = np.log(CORNERS_HZ)
        gyro, accel = np.exp(self._rng(1).uniform(low, high, 2)).tolist()
        return (gyro, accel) if self.has_low_pass else None

    @property
    def delay_s(self) -> float:
        """By which the unit's stamps are late; early where negative."""
        rng = self._rng(2)
        return float(rng.uniform(*DELAYS_S) * rng.choice((-1.0, 1.0))) if self.has_delay else 0.0

    @property
    def group_delays_s(self) -> tuple[float, float]:
        """Of gyros and accelerometers at low frequency: the clock's and √2·T of a filter."""
        gyro, accel = (self.delay_s + float(np.sqrt(2.0)) * T for T in self.time_constants_s)
        return gyro, accel

    @property
    def time_constants_s(self) -> tuple[float, float]:
        """1/(2πf) of gyros and accelerometers; nothing without a filter, as an AHRS's gyros are.

        The station's filter is digital: at low frequency it acts as the analogue one from which
        the bilinear transform makes it, whose corner is 2/h·tan(π·f·h)/(2π).
        """
        if self.corners_hz is None:
            return 0.0, 0.0
        gyro, accel = (0.5 * STEP_S / float(np.tan(np.pi * hz * STEP_S)) for hz in self.corners_hz)
        return (0.0 if self.procedure == "jjf1536" else gyro), accel

    @cached_property
    def station(self) -> VirtualStation:
        """The virtual station with this unit."""
        drawn = virtual_station(self.seed, ahrs=self.procedure == "jjf1536")
        corners = self.corners_hz or (NO_FILTER_HZ, NO_FILTER_HZ)
        triads = {
            name: getattr(drawn.unit, name).model_copy(update={"bandwidth_hz": hz})
            for name, hz in zip(("gyro", "accel"), corners, strict=True)
        }
        return drawn.model_copy(update={"unit": drawn.unit.model_copy(update=triads)})

    def _rng(self, purpose: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence((self.seed, 40 + purpose)))


def cases(count: int) -> tuple[Case, ...]:
    """The first so many of 160: each unit with both, one or neither, by one procedure or the other.

    In the first eighty every condition has both procedures in turn, and each of these a busy
    computer every other time; then procedures and computers change places.
    """
    conditions = tuple(product((True, False), repeat=2))
    every = (
        Case(seed, procedure, low_pass, delay, (seed // 2 + k + turn) % 2 == 0)
        for turn in range(2)
        for seed in range(1, SEEDS + 1)
        for k, (low_pass, delay) in enumerate(conditions)
        for procedure in [PROCEDURES[(seed + k + turn) % 2]]
    )
    return tuple(islice(every, count))
