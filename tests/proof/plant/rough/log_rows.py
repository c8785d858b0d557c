"""What the logger does to rows and stamps: held, doubled, interpolated, scattered, in batches."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Parameters
from tests.proof.plant.rough.logged import Logged, Rows
from tests.proof.plant.rough.reference import scattered
from tests.proof.plant.world import Setting


class HeldRows(Logged):
    """The sensor is slower than the log: its last sample is written again until the next comes."""

    name, form = "repeated_samples", "repeated_samples_held"
    units: ClassVar = {"rate": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"rate": float(rng.choice([0.25, 0.5, rng.uniform(0.55, 0.95)]))}

    def logged(self, rows: Rows) -> Rows:
        new = np.floor(np.arange(len(rows.stamp)) * self.parameters["rate"])
        first = np.searchsorted(new, new)
        return replace(rows, readings=rows.readings[:, first])


class DoubledRows(Logged):
    """A share of the rows is missed, and the row before is written in its place."""

    name, form = "repeated_samples", "repeated_samples_doubled"
    units: ClassVar = {"share": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"share": float(rng.uniform(0.03, 0.3))}

    def logged(self, rows: Rows) -> Rows:
        count = len(rows.stamp)
        fresh = self.rng().uniform(size=count) >= self.parameters["share"]
        fresh[0] = True
        source = np.maximum.accumulate(np.where(fresh, np.arange(count), 0))
        return replace(rows, readings=rows.readings[:, source])


class InterpolatedRows(Logged):
    """The log was brought to a higher rate by straight lines between every n-th reading."""

    name, form = "repeated_samples", "repeated_samples_interpolated"
    units: ClassVar = {"every": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"every": int(rng.integers(2, 6))}

    def logged(self, rows: Rows) -> Rows:
        kept = slice(None, None, self.parameters["every"])
        lines = [np.interp(rows.stamp, rows.stamp[kept], each[kept]) for each in rows.readings]
        return replace(rows, readings=np.stack(lines))


class ScatteredStamps(Logged):
    """The stamp is written when the host gets to it: it scatters about the true instant."""

    name = form = "timestamp_jitter"
    units: ClassVar = {"sigma": "s"}
    sized: ClassVar[tuple[str, ...]] = ("sigma",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"sigma": 2e-3}

    def logged(self, rows: Rows) -> Rows:
        return replace(rows, stamp=scattered(self.rng(), rows.stamp, self.parameters["sigma"]))


class BatchedStamps(Logged):
    """Rows arrive in batches and get stamps that close up to the batch's arrival."""

    name, form = "timestamp_jitter", "timestamp_jitter_batched"
    units: ClassVar = {"batch": "1", "squeeze": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"batch": int(rng.integers(3, 9)), "squeeze": float(rng.uniform(0.5, 0.95))}

    def logged(self, rows: Rows) -> Rows:
        batch, count = self.parameters["batch"], len(rows.stamp)
        last = np.minimum(np.arange(count) // batch * batch + batch - 1, count - 1)
        away = rows.stamp[last] - rows.stamp
        mean = float(np.mean(away)) * self.parameters["squeeze"]  # the mean instant stays
        return replace(rows, stamp=rows.stamp + self.parameters["squeeze"] * away - mean)
