"""A recording as every peer sees it: blocks, the standard's model fitted, noise, library, folds.

The inputs, their block means and the folds are those of `explain` itself, so that nobody has
better ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording
from tasks.explain.evidence.cells import FOLDS, fold_cells
from tasks.explain.inputs.blocks import Blocks, block_means
from tasks.explain.inputs.full_rate import full_rate
from tasks.model.term import Inputs
from tasks.model.terms.standard import STANDARD_TERMS
from tests.proof.peers.blocks import BLOCK_RATE
from tests.proof.peers.library import library, polynomial
from tests.proof.peers.noise import TRIADS, Noise, noises_of, whitened

CHANNELS = GYRO + ACCEL
SAME = 1e-9  # of a column's power: what is left of it when others tell it whole


@dataclass(frozen=True)
class Observation:
    """fold: (n,) 0 to 3. standard: (n, b) columns of each channel. nominal: (n, 6) the standard's
    model, fitted. noises: of the six channels; used: those that were recorded."""

    observed: Blocks
    fold: np.ndarray
    standard: tuple[np.ndarray, ...]
    nominal: np.ndarray
    noises: tuple[Noise, ...]

    @cached_property
    def left(self) -> np.ndarray:
        """(n, 6) what the standard's model leaves; 0 where nothing is known."""
        return np.where(self.observed.weight > 0, self.observed.readings - self.nominal, 0.0)

    @property
    def used(self) -> tuple[int, ...]:
        return tuple(int(c) for c in np.flatnonzero(self.observed.weight.any(axis=0)))

    @cached_property
    def library(self) -> dict[str, np.ndarray]:
        return library(self.observed.motion)

    @cached_property
    def polynomial_names(self) -> frozenset[str]:
        return frozenset(polynomial(self.observed.motion))

    @cached_property
    def equations(self) -> "tuple[Equations | None, ...]":
        """Whitened normal equations of each channel; None for one that was not recorded."""
        made = [_triad_equations(self, triad) for triad in TRIADS]
        return tuple(each for triad in made for each in triad)


@dataclass(frozen=True)
class Equations:
    """Normal equations of one channel: base columns, library columns, what was left.

    grams: (FOLDS, m, m) whitened, in that order. base: how many columns the standard has.
    scale: (m − 1,) by which the columns were divided. names: of the library's columns.
    """

    grams: np.ndarray
    base: int
    scale: np.ndarray
    names: tuple[str, ...]

    def without(self, fold: int | None) -> np.ndarray:
        """The Gram matrix of all folds, or of all but one."""
        whole = self.grams.sum(axis=0)
        return np.asarray(whole if fold is None else whole - self.grams[fold])


def see(recording: Recording) -> Observation:
    """Raises Unusable where the recording has no motion, rates or forces, or is too short."""
    return observation_of(block_means(full_rate(recording), BLOCK_RATE))


def observation_of(observed: Blocks) -> Observation:
    """Fits the standard's model twice: plainly for the noise, then weighed by that noise."""
    standard = standard_columns(observed)
    fold = fold_cells(observed) % FOLDS
    plain = _fitted(observed, standard, None)
    noises = noises_of(observed, observed.readings - plain)
    nominal = plain + _fitted(observed, standard, noises, observed.readings - plain)
    return Observation(observed, fold, standard, nominal, noises)


def standard_columns(observed: Blocks) -> tuple[np.ndarray, ...]:
    """Columns (n, b) of models (1) and (2) for each channel; 0 where the motion is not known."""
    motion = observed.motion
    columns: list[list[np.ndarray]] = [[] for _ in CHANNELS]
    for term in STANDARD_TERMS:
        for column in term.columns(motion, Inputs(motion.rate, motion.force)):
            for channel, series in column.items():
                columns[channel].append(np.nan_to_num(series))
    return tuple(np.column_stack(each) for each in columns)


def _fitted(
    observed: Blocks,
    standard: tuple[np.ndarray, ...],
    noises: tuple[Noise, ...] | None,
    readings: np.ndarray | None = None,
) -> np.ndarray:
    """(n, 6) least squares of the standard's columns; weighed by a noise spectrum where given."""
    declared = observed.readings if readings is None else readings
    fitted = np.zeros_like(declared)
    for c in np.flatnonzero(observed.weight.any(axis=0)):
        size = np.sqrt((standard[c] ** 2).mean(axis=0)) + 1e-300
        stack = np.vstack([(standard[c] / size).T, declared[:, c]]) * observed.weight[:, c]
        if noises is not None:
            stack = whitened(stack, noises[c], observed.rate)
        values, *_ = np.linalg.lstsq(stack[:-1].T, stack[-1], rcond=1e-9)
        fitted[:, c] = standard[c] @ (values / size)
    return fitted


def _triad_equations(observation: Observation, triad: slice) -> list[Equations | None]:
    """Every column is whitened once for a triad, whose channels differ in white noise alone."""
    observed, channels = observation.observed, range(6)[triad]
    used = [c for c in channels if c in observation.used]
    if not used:
        return [None] * len(channels)
    first = observation.noises[used[0]]
    names = tuple(observation.library)
    rows = [
        *(observation.standard[c].T for c in channels),
        *(observation.library[name] for name in names),
    ]
    stack = np.vstack([*rows, observation.left[:, triad].T])
    weight = observed.weight[:, used].mean(axis=1)
    size = np.sqrt((stack**2).mean(axis=1)) + 1e-300
    flat = whitened(stack / size[:, None] * weight, first, observed.rate)
    grams = np.array([_gram(flat[:, observation.fold == k]) for k in range(FOLDS)])
    width = observation.standard[channels[0]].shape[1]
    shared = list(range(3 * width, 3 * width + len(names)))
    made: list[Equations | None] = []
    for i, c in enumerate(channels):
        if c not in used:
            made.append(None)
            continue
        reading = 3 * width + len(names) + i
        which = [*range(i * width, (i + 1) * width), *shared, reading]
        factor = np.ones(len(which))
        factor[-1] = size[reading]
        factor *= np.sqrt(first.white / observation.noises[c].white)
        own = grams[:, which][:, :, which] * factor[:, None] * factor
        made.append(Equations(own, width, size[which[:-1]], names))
    return made


def _gram(part: np.ndarray) -> np.ndarray:
    return np.asarray(part @ part.T)
