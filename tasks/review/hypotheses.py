"""Effects that runs may have in common: terms of the catalogue, whole and in parts."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from schemas.discrepancy import Layout, PooledParameter, PooledTerm
from schemas.recording import Recording
from tasks.explain.search.candidates import parts_of
from tasks.model.term import Inputs, Term, single
from tasks.model.terms.axes import level_axes
from tasks.motion.whole import Motion

# Earth's rotation in the table's own directions, where the site is unknown.

NAME = "ground_rotation"


@dataclass(frozen=True)
class GroundRotation(Term):
    """A rate (3,) of the ground: along the table's x and y axes with all angles zero, and up."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        level = level_axes(motion)
        rate = values[2] * motion.up
        if level is not None:
            rate = rate + values[0] * level[0] + values[1] * level[1]
        return Inputs(inputs.rate + rate, inputs.force)


PRINTED = ("deg/h", "rad/s", 1e-3)
GROUND_ROTATION = GroundRotation(
    NAME, "site", "input", "ω = ω_table + Ω_x·x + Ω_y·y + Ω_z·up", "rigid-body kinematics",
    single("x", "Ω_x", PRINTED) + single("y", "Ω_y", PRINTED) + single("up", "Ω_z", PRINTED),
)  # fmt: skip


def ground_rotation(recording: Recording) -> tuple[Term, ...]:
    """The term of a run whose manifest omits latitude and heading."""
    station = recording.manifest.station
    if station.latitude_deg is not None and station.heading_deg is not None:
        return ()
    return (GROUND_ROTATION,)


TermIdentity = tuple[str, tuple[float, ...], tuple[str, ...]]


@dataclass(frozen=True)
class Effect:
    """A term with some of its parameters.

    own: numbers of its parameters within the term. trials: how many effects of its name are tried.
    """

    term: PooledTerm
    own: tuple[int, ...]
    trials: int = 1

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def parameters(self) -> tuple[PooledParameter, ...]:
        return tuple(self.term.parameters[q] for q in self.own)

    @property
    def unlikely(self) -> float:
        """Twice the nats that it costs to be one of many of its name, or rare."""
        return 2.0 * math.log(self.trials) + self.term.rarity

    @property
    def one_sided(self) -> bool:
        """Whether none of its parameters can be negative, such as a time constant."""
        return all(parameter.low == 0.0 for parameter in self.parameters)


def identity(term: PooledTerm) -> TermIdentity:
    """By which the same term is recognised in another run."""
    return term.name, term.at, tuple(parameter.name for parameter in term.parameters)


def effects_of(layouts: Iterable[Layout]) -> tuple[Effect, ...]:
    """Every effect of some layouts, each once."""
    terms: dict[TermIdentity, PooledTerm] = {}
    for layout in layouts:
        for term in layout.terms:
            if term.name != NAME:
                terms.setdefault(identity(term), term)
    effects = [
        Effect(term, part)
        for term in terms.values()
        for part in parts_of([parameter.channels for parameter in term.parameters])
    ]
    counts = Counter(effect.name for effect in effects)
    return tuple(replace(effect, trials=counts[effect.name]) for effect in effects)


def starts_of(layout: Layout) -> Mapping[TermIdentity, int]:
    """Where the parameters of each term begin among those of a layout."""
    starts, at = dict[TermIdentity, int](), 0
    for term in layout.terms:
        starts[identity(term)] = at
        at += len(term.parameters)
    return starts


def members_of(effect: Effect, starts: Mapping[TermIdentity, int]) -> Sequence[int] | None:
    """The numbers of an effect's parameters; None where the layout has no such term."""
    start = starts.get(identity(effect.term))
    return None if start is None else [start + q for q in effect.own]


# Each run's evidence for an effect, in coordinates of the mean information.

DETERMINED = 1e-4  # of a parameter's information that is left beside the effect's others


@dataclass(frozen=True)
class Evidence:
    """Score (runs, m) and information (runs, m, m) in coordinates in which the mean information of
    the runs is one. back: (parameters, m) from these coordinates to SI. unit: (runs,) number of the
    unit, from 0.
    """

    score: np.ndarray
    information: np.ndarray
    back: np.ndarray
    unit: np.ndarray

    @property
    def size(self) -> int:
        return int(self.score.shape[1])

    def of(self, rows: np.ndarray) -> "Evidence":
        """Of some runs (runs,) bool alone, in the same coordinates."""
        information = self.information * rows[:, None, None]
        return Evidence(self.score * rows[:, None], information, self.back, self.unit)

    @cached_property
    def units(self) -> int:
        """How many units have runs."""
        return int(self.unit.max()) + 1

    @cached_property
    def of_each_unit(self) -> csr_array:
        """(units, runs) 1 where a run is of a unit."""
        return self.of_units(np.ones((1, len(self.unit)), bool))

    def of_units(self, rows: np.ndarray) -> csr_array:
        """(w · units, runs) 1 where a run of a unit is in a window; rows: (w, runs) bool."""
        window, run = np.nonzero(rows)
        place = window * self.units + self.unit[run]
        size = (len(rows) * self.units, len(self.unit))
        return csr_array((np.ones(len(run)), (place, run)), size)


def at_unit_information(score: np.ndarray, information: np.ndarray, unit: np.ndarray) -> Evidence:
    """Evidence without what no run determines."""
    seen = int(information.any(axis=(1, 2)).sum())
    back = back_from_unit_information(information.sum(axis=0) / max(1, seen))
    turned = information.reshape(len(score), -1) @ np.kron(back, back)  # of all runs at once
    return Evidence(score @ back, turned.reshape(len(score), *[back.shape[1]] * 2), back, unit)


def back_from_unit_information(mean: np.ndarray) -> np.ndarray:
    """(parameters, m) from coordinates in which a mean information is one to SI."""
    size = np.sqrt(np.diag(mean))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    values, vectors = np.linalg.eigh(mean * scale[:, None] * scale)
    kept = values > DETERMINED
    return np.asarray(scale[:, None] * vectors[:, kept] / np.sqrt(values[kept]))


def solved(information: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of symmetric systems (…, m, m), (…, m); what nothing determines is zero."""
    return np.asarray(np.linalg.solve(ridged(information), right[..., None])[..., 0])


def ridged(information: np.ndarray) -> np.ndarray:
    """Information (…, m, m) with a little of its own size on the diagonal."""
    ridge = 1e-9 + 1e-6 * np.einsum("...ii->...", information)[..., None, None]
    return np.asarray(information + ridge * np.eye(information.shape[-1]))
