"""The unit's samples in the order of their time stamps, without invalid ones."""

import numpy as np

from schemas.unit_link import UnitLink
from tasks.station.drivers.samples import counter_turn, no_samples, stamp_turn_us

LONGEST_STEP_US = 3_000_000
STEPS = 10  # of a slow unit, that a step may be long


class StampSequence:
    """Takes the samples found, and returns those with consistent stamps.

    A sample whose stamp does not follow the previous one counts only if the next one follows it:
    the unit was silent, or was restarted. Otherwise garbage happened to look like a frame, and
    `rejected` counts it. Stamps continue where the unit's own wrap; without a stamp in the frame
    they are those of the counter, at the rate of the link, or of arrival.
    """

    def __init__(self, link: UnitLink) -> None:
        self.rejected = 0
        self._link = link
        self._turn_us = self._turn()
        self._longest_us = max(LONGEST_STEP_US, STEPS * 1e6 / link.rate_hz)
        self._held = no_samples(link.frame)
        self._last_us: int | None = None  # as the unit tells it
        self._own_us: int | None = None  # of the last sample given
        self._before_us = 0  # what it has turned over by

    def _turn(self) -> int | None:
        if not self._link.frame.has("time") and self._link.frame.has("counter"):
            return round(counter_turn(self._link.frame) * 1e6 / self._link.rate_hz)
        return stamp_turn_us(self._link.frame)

    def take(self, samples: np.ndarray, arrived_s: float) -> np.ndarray:
        """The samples (n,) whose place is known now; the last may be kept for the next call."""
        self._stamp(samples, arrived_s)
        waiting = np.concatenate([self._held, samples])
        kept = self._following(waiting)
        self._run_on(kept)
        return kept

    def _stamp(self, samples: np.ndarray, arrived_s: float) -> None:
        """Stamps for frames that have none. Those that came together are a period apart."""
        period_us = 1e6 / self._link.rate_hz
        if self._link.frame.has("time"):
            return
        if self._link.frame.has("counter"):
            samples["stamp"] = np.rint(samples["counter"] * period_us)
            return
        back = np.arange(len(samples) - 1, -1, -1)
        samples["stamp"] = np.rint(arrived_s * 1e6 - back * period_us)
        if self._last_us is not None and len(samples):
            late_us = self._last_us + 1 - int(samples["stamp"][0])
            samples["stamp"] += max(late_us, 0)

    def _following(self, waiting: np.ndarray) -> np.ndarray:
        stamps = waiting["stamp"]
        if self._last_us is not None:
            before = np.concatenate([[self._last_us], stamps[:-1]])
            if self._follows(before, stamps).all():
                self._held = waiting[:0]
                self._last_us = int(stamps[-1]) if len(stamps) else self._last_us
                return waiting.copy()
        return self._sound(waiting)

    def _sound(self, waiting: np.ndarray) -> np.ndarray:
        """The consistent samples, in order; the last is held back if the next one must decide."""
        stamps, kept, last_us = waiting["stamp"].tolist(), [], self._last_us
        self._held = waiting[:0]
        for place, stamp in enumerate(stamps):
            follows = self._comes_after(last_us, stamp)
            if not follows and place + 1 == len(stamps):
                self._held = waiting[place:]
            elif follows or self._is_borne_out(last_us, stamp, stamps[place + 1]):
                kept.append(place)
                last_us = stamp
            else:
                self.rejected += 1
        self._last_us = last_us
        return waiting[kept]

    def _is_borne_out(self, last_us: int | None, stamp: int, following: int) -> bool:
        """Whether the sample behind it follows it, and not the one before it."""
        return self._comes_after(stamp, following) and not self._comes_after(last_us, following)

    def _comes_after(self, last_us: int | None, stamp: int) -> bool:
        return last_us is not None and bool(self._follows(last_us, stamp))

    def _follows(self, before: np.ndarray | int, stamps: np.ndarray | int) -> np.ndarray:
        steps = np.asarray(stamps) - np.asarray(before)
        if self._turn_us is not None:
            steps = steps % self._turn_us
        return np.asarray((steps > 0) & (steps <= self._longest_us))

    def _run_on(self, samples: np.ndarray) -> None:
        """Adds the wraps of the stamps; a restart is none."""
        if self._turn_us is None or not len(samples):
            return
        own = samples["stamp"].copy()
        before = np.concatenate([[self._own_us if self._own_us is not None else own[0]], own])
        turns = (np.diff(before) < 0) & self._follows(before[:-1], before[1:])
        samples["stamp"] += self._before_us + np.cumsum(turns) * self._turn_us
        self._before_us += int(turns.sum()) * self._turn_us
        self._own_us = int(own[-1])
