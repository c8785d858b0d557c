"""What may be missing: the catalogue's terms and empirical ones, as columns of the pool."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.explain.search.empirical_terms import slow_drift
from tasks.model.term import Column, Inputs, Term
from tasks.motion.whole import Motion

STEP = 1e-3  # of the plausible range: small enough to be linear
WAVES = 30  # of a slow course, half a period and more over the run
# Powers and knees: a random walk, what drifts more smoothly, and what returns after a while (Gauss
# and Markov's process, a signal that jumps to and fro).
WALK, SMOOTH, RETURNING = (2.0, 0.0), (4.0, 0.0), ((2.0, 6.0), (2.0, 15.0))
STRENGTHS = (0.3, 3.0, 30.0, 300.0, 3000.0)
JUMPS = 3  # times at which something may happen that are tried


@dataclass(frozen=True)
class Prior:
    """Slow waves k = 1, 2, … of random size: variance q/(knee² + k²)^(power/2) in each channel.

    strength: variance of the fourth wave, in units of that with which it is measured. knee: the
    wave from which on they grow smaller; zero for what never returns.
    """

    power: float
    strength: float
    knee: float = 0.0

    def precision(self, power_of_columns: np.ndarray) -> np.ndarray:
        """1/variance (m,) of parameters at unit column size; power_of_columns: (m,) = uᵀS⁻¹u."""
        waves = power_of_columns.reshape(-1, WAVES)
        k = np.arange(1.0, WAVES + 1.0)
        size = np.where(waves[:, 3] > 0, waves[:, 3], 1.0)[:, None]
        shape = (self.knee**2 + 16.0) / (self.knee**2 + k**2)
        variance = self.strength / size * shape ** (0.5 * self.power)
        return np.asarray(1.0 / (variance * np.maximum(waves, 1e-300))).ravel()


@dataclass(frozen=True, eq=False)
class Candidate:
    """A term with some of its parameters, or all of them.

    members: numbers of its parameters within the pool; own: within the term. tried: how many
    members of its name were tried, which it is charged for. prior: of a course that is drawn at
    random, whose many parameters are charged by their evidence instead. looked: how many times or
    periods its shape was proposed from. fitted: its shape is where a fit put it.
    """

    term: Term
    members: tuple[int, ...]
    own: tuple[int, ...]
    tried: int
    prior: Prior | None = None
    looked: float = 1.0
    fitted: bool = False

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def key(self) -> tuple[tuple[str, int], tuple[int, ...], Prior | None]:
        """By which a candidate is recognised, whatever the shape of its term."""
        return self.term.key, self.own, self.prior

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
        found.append(_column((_read(term, motion, step) - plain) / step[p], plain))
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
    """The candidates of some terms, whole and in parts, and the columns they share.

    A term that tells a `time` of what it does is tried at JUMPS times, which are proposed later;
    `bias_random_walk` and its smoother sister are courses drawn at random.
    """
    columns: list[Column] = []
    found: list[tuple[Term, tuple[int, ...], tuple[int, ...]]] = []
    variants = [variant for term in terms for variant in _variants(term, motion)]
    for number, variant in enumerate(variants):
        term = replace(variant, variant=number)
        own = columns_of(term, motion)
        first = len(columns)
        columns.extend(own)
        if not any(own):
            continue
        for part in _parts(own):
            found.append((term, tuple(first + p for p in part), part))
    slow = tuple(_slow_ones(terms, len(columns), len(variants)))
    columns.extend(slow[0].term.columns(motion, Inputs(motion.rate, motion.force)))
    tried: dict[str, int] = {}
    for name in [term.name for term, _, _ in found] + [one.name for one in slow]:
        tried[name] = tried.get(name, 0) + 1
    plain = (Candidate(t, m, o, tried[t.name]) for t, m, o in found)
    return (*plain, *(replace(one, tried=tried[one.name]) for one in slow)), tuple(columns)


def plausible_sizes(candidates: Sequence[Candidate], count: int) -> np.ndarray:
    """(count,) half of each parameter's plausible range; infinite where nothing is known of it."""
    half = np.full(count, np.inf)
    for one in candidates:
        if one.prior is None and not one.known:
            for p, q in zip(one.members, one.own, strict=True):
                low, high = one.term.parameters[q].plausible
                half[p] = 0.5 * (high - low)
    return half


def _variants(term: Term, motion: Motion) -> Iterator[Term]:
    """The term at many times, where its shape is the time at which something happens."""
    if [shape.name for shape in term.shapes] != ["time"]:
        yield term
        return
    for n in range(JUMPS):
        share = (n + 1.0) / (JUMPS + 1.0)
        yield term.shaped((float(motion.t[0] + share * (motion.t[-1] - motion.t[0])),))


def _slow_ones(terms: Sequence[Term], first: int, variant: int) -> Iterator[Candidate]:
    """Candidates that share the columns of slow waves in all channels, WAVES for each."""
    walk = next((term for term in terms if term.time_course == "random walk"), None)
    for number, form in enumerate((WALK, SMOOTH, *RETURNING), variant):
        if form == WALK and walk is None:
            continue
        term = replace(slow_drift(walk if form == WALK else None, WAVES), variant=number)
        for part in (tuple(range(6)), *TRIADS, *((c,) for c in range(6))):
            own = tuple(WAVES * c + k for c in part for k in range(WAVES))
            members = tuple(first + p for p in own)
            for strength in STRENGTHS:
                yield Candidate(term, members, own, 1, Prior(form[0], strength, form[1]))


def _parts(columns: Sequence[Column]) -> Iterator[tuple[int, ...]]:
    """All parameters; and, where each reads one channel alone, those of a triad, of a channel."""
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
