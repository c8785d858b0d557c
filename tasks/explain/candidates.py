"""What may be missing: the catalogue's terms and empirical ones, as columns of the pool."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tasks.model.term import Column, Inputs, Term
from tasks.motion.whole import Motion

STEP = 1e-3  # of the plausible range: small enough to be linear
TRIADS = ((0, 1, 2), (3, 4, 5))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A term with some of its parameters, or all of them.

    members: numbers of its parameters within the pool; own: within the term. family: how many
    members of its name were tried, which it is charged for.
    """

    term: Term
    members: tuple[int, ...]
    own: tuple[int, ...]
    tried: int

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def known(self) -> bool:
        """Physics without a free parameter: its one column has the factor one."""
        return not self.term.parameters


def columns_of(term: Term, motion: Motion) -> tuple[Column, ...]:
    """Readings of an ideal unit per unit of each parameter; the whole effect if it has none."""
    inputs = Inputs(motion.rate, motion.force)
    if term.stage == "sensor":
        return term.columns(motion, inputs)
    plain = np.hstack([inputs.rate, inputs.force])
    if not term.parameters:
        return (_column(_read(term, motion, np.zeros(0)) - plain, plain),)
    found = []
    for p, parameter in enumerate(term.parameters):
        low, high = parameter.plausible
        step = np.zeros(len(term.parameters))
        step[p] = STEP * (high - low)
        rise = _read(term, motion, step) - _read(term, motion, -step)
        found.append(_column(rise / (2.0 * step[p]), plain))
    return tuple(found)


def _read(term: Term, motion: Motion, values: np.ndarray) -> np.ndarray:
    """(n, 6) readings of an ideal unit with one term."""
    moved = term.moved(motion, values)
    inputs = term.felt(moved, Inputs(moved.rate, moved.force), values)
    return term.passed(moved, np.hstack([inputs.rate, inputs.force]), values)


def _column(change: np.ndarray, plain: np.ndarray) -> Column:
    """The channels that follow, beyond what arithmetic leaves."""
    size = np.nanmax(np.abs(change), axis=0, initial=0.0)
    triads = np.repeat([np.nanmax(size[:3]), np.nanmax(size[3:])], 3)
    return {c: change[:, c] for c in range(6) if size[c] > 1e-6 * triads[c] > 0.0}


def candidates_of(
    terms: Sequence[Term], motion: Motion
) -> tuple[tuple[Candidate, ...], tuple[Column, ...]]:
    """The candidates of some terms, whole and in parts, and the columns they share."""
    columns: list[Column] = []
    found: list[tuple[Term, tuple[int, ...], tuple[int, ...]]] = []
    for term in terms:
        own = columns_of(term, motion)
        first = len(columns)
        columns.extend(own)
        if not any(own):
            continue
        for part in _parts(own):
            found.append((term, tuple(first + p for p in part), part))
    tried: dict[str, int] = {}
    for term, _, _ in found:
        tried[term.name] = tried.get(term.name, 0) + 1
    return tuple(Candidate(t, m, o, tried[t.name]) for t, m, o in found), tuple(columns)


def _parts(columns: Sequence[Column]) -> Iterator[tuple[int, ...]]:
    """All parameters; and, where each reads one channel alone, those of a triad and of a channel."""
    seen = [p for p, column in enumerate(columns) if column]
    yield tuple(seen)
    if any(len(columns[p]) > 1 for p in seen) or len(seen) < 2:
        return
    by_channel: dict[int, list[int]] = {}
    for p in seen:
        by_channel.setdefault(next(iter(columns[p])), []).append(p)
    triads = [[p for c in triad for p in by_channel.get(c, [])] for triad in TRIADS]
    both = all(triads)
    parts = [tuple(triad) for triad in triads if triad and both]
    parts += [tuple(some) for some in by_channel.values() if len(by_channel) > 1]
    yield from dict.fromkeys(part for part in parts if len(part) < len(seen))
