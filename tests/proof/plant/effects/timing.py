"""Time: two clocks, one converter for several axes, samples that never arrive."""

from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Effect, Parameters
from tests.proof.plant.world import Setting


class TimeOffset(Effect):
    """The unit's stamps are late by `seconds`: what it stamps t happened at t − seconds."""

    name = "time_offset"
    units: ClassVar = {"seconds": "s"}
    sized = ("seconds",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"seconds": float(1e-3 * rng.choice([-1.0, 1.0]))}

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        return stamp - self.parameters["seconds"]


class ClockSkew(Effect):
    """The unit's clock runs fast by a share: what it stamps t happened at t / (1 + share)."""

    name = "clock_skew"
    units: ClassVar = {"share": "1"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"share": float(1e-6 * rng.choice([-1.0, 1.0]))}

    def true_time(self, stamp: np.ndarray) -> np.ndarray:
        return np.asarray(stamp / (1.0 + self.parameters["share"]))


class AccelAxisSkew(Effect):
    """One converter serves the accelerometers in turn: x on time, y and z one and two steps later.

    The stamp is that of the first.
    """

    name = "accel_axis_skew"
    units: ClassVar = {"step": "s"}
    sized = ("step",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"step": 1e-3}

    def delays(self) -> np.ndarray:
        return np.array([0.0, 0.0, 0.0, 0.0, 1.0, 2.0]) * self.parameters["step"]


class DroppedSamples(Effect):
    """Runs of samples are lost; stamps are counted up from what arrives, so later ones slip.

    times: when each run begins, true time. lost: samples in each run, 2 at strength 1, at least 1.
    """

    name = "dropped_samples"
    units: ClassVar = {"times": "s", "lost": "1"}
    sized = ("lost",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        events = int(rng.integers(1, 4))
        times = np.sort(rng.uniform(0.1, 0.6, events)) * setting.plan.duration
        return {"times": times.tolist(), "lost": [2] * events}

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        lost = [max(1, round(number * strength)) for number in typical["lost"]]
        return {"times": typical["times"], "lost": lost}

    def kept(self, count: int) -> np.ndarray:
        kept = np.ones(count, dtype=bool)
        starts = self.value("times") * self.setting.case.rate_hz
        for start, lost in zip(starts.astype(int), self.parameters["lost"], strict=True):
            kept[start : start + lost] = False
        return kept
