"""Candidates: terms of the catalogue and empirical ones, as columns of a design matrix."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.channels import EVERY, TRIADS
from tasks.explain.search.behaviours import UnlistedForm
from tasks.explain.search.empirical_terms import scale_factor_drift, slow_drift
from tasks.model.term import Column, Inputs, Term
from tasks.model.terms.electronics import BANDWIDTH
from tasks.motion.whole import Motion

LINEAR_STEP = 1e-3  # of the plausible range: small enough to be linear
NUMERICAL_ZERO = 1e-6  # of the largest change in a triad
COSINES = 30  # of a random drift, half a period and more over the run
# Powers and corners: a random walk, what drifts more smoothly, and what returns after a while
# (Gauss–Markov process, random telegraph signal).
Form = tuple[float, float]
WALK, SMOOTH, RETURNING = (2.0, 0.0), (4.0, 0.0), ((2.0, 6.0), (2.0, 15.0))
BIAS_FORMS = (WALK, SMOOTH, *RETURNING)
SCALE_FORMS = (SMOOTH, *RETURNING)
STRENGTHS = (0.3, 3.0, 30.0, 300.0, 3000.0)
WEIGHTS = (10.0, 100.0, 1e3, 1e4, 1e5)  # strengths of an unlisted form
UNSEEN = 1e-12  # of the clearest column's power: less shows nothing of a weight
STEP_TIMES = 3  # at which a change may happen that are tried


@dataclass(frozen=True)
class Prior:
    """Random cosines k = 1, 2, …: variance q/(corner² + k²)^(power/2) in each channel.

    strength: variance of the fourth cosine, in units of that with which it is measured. corner:
    the number from which on they grow smaller; zero for what never returns.
    """

    power: float
    strength: float
    corner: float = 0.0

    @property
    def columns(self) -> int:
        """In each channel."""
        return COSINES

    def precision(self, column_power: np.ndarray) -> np.ndarray:
        """1/variance (m,) of parameters at unit column size; column_power: (m,) = uᵀS⁻¹u."""
        power = column_power.reshape(-1, COSINES)
        k = np.arange(1.0, COSINES + 1.0)
        size = np.where(power[:, 3] > 0, power[:, 3], 1.0)[:, None]
        shape = (self.corner**2 + 16.0) / (self.corner**2 + k**2)
        variance = self.strength / size * shape ** (0.5 * self.power)
        return np.asarray(1.0 / (variance * np.maximum(power, 1e-300))).ravel()


@dataclass(frozen=True)
class Weights:
    """Weights of one variance: of the columns, as large as they are, that an unlisted form has.

    strength: variance of the weight of the clearest column, in units of that with which it is
    measured. columns: in each channel.
    """

    strength: float
    columns: int

    def precision(self, column_power: np.ndarray) -> np.ndarray:
        """1/variance (m,) of parameters at unit column size; column_power: (m,) = uᵀS⁻¹u."""
        power = column_power.reshape(-1, self.columns)
        clearest = np.maximum(power.max(axis=1, keepdims=True), 1e-300)
        return np.asarray(1.0 / (self.strength * np.maximum(power / clearest, UNSEEN))).ravel()


@dataclass(frozen=True, eq=False)
class Candidate:
    """A term with some of its parameters, or all of them.

    members: numbers of its parameters within the design; own: within the term. trials: how many
    candidates of its name are tried, which it is charged for. prior: of a random drift, whose many
    parameters are charged by their evidence instead. shape_trials: independent times or periods
    that its shape was the best of. fitted: a fit adjusted its shape. nuisance: it is in every model
    of such a recording, and not searched for.
    """

    term: Term
    members: tuple[int, ...]
    own: tuple[int, ...]
    trials: int
    prior: Prior | Weights | None = None
    shape_trials: float = 1.0
    fitted: bool = False
    nuisance: bool = False

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def key(self) -> tuple[tuple[str, int], tuple[int, ...], Prior | Weights | None]:
        """By which a candidate is recognised, whatever the shape of its term."""
        return self.term.key, self.own, self.prior

    @property
    def on_grid(self) -> bool:
        """Whether it has a continuous shape that no fit has adjusted yet."""
        return self.term.has_continuous_shape and not self.fitted

    @property
    def unlisted(self) -> bool:
        """Whether it is a kind of behaviour in a form that no publication lists."""
        return isinstance(self.prior, Weights)

    def is_form_of(self, names: Collection[str]) -> bool:
        """Whether it is a listed form of an effect of one of these names."""
        return self.name in names and not self.unlisted

    @property
    def known(self) -> bool:
        """Physics without a free parameter: its one column has the factor one."""
        return not self.term.parameters


def members_of(candidates: Sequence[Candidate]) -> list[int]:
    """The numbers of all their parameters within the design, in order."""
    return sorted({p for candidate in candidates for p in candidate.members})


def columns_of(term: Term, motion: Motion) -> tuple[Column, ...]:
    """Readings of an ideal unit per unit of each parameter; the whole effect if it has none."""
    inputs = Inputs.of(motion)
    own = term.columns(motion, inputs)
    if term.stage == "sensor":
        return own
    if own:
        return tuple({c: signal for c, signal in one.items() if np.nan_to_num(signal).any()}
                     for one in own)  # fmt: skip
    ideal = np.hstack([inputs.rate, inputs.force])
    if not term.parameters:
        return (_column(_readings(term, motion, np.zeros(0)) - ideal),)
    steps = np.diag([LINEAR_STEP * np.ptp(p.plausible) for p in term.parameters])
    return tuple(
        _column((_readings(term, motion, step) - ideal) / step[p]) for p, step in enumerate(steps)
    )


def _readings(term: Term, motion: Motion, values: np.ndarray) -> np.ndarray:
    """(n, 6) readings of an ideal unit with one term."""
    moved = term.moved(motion, values)
    inputs = term.felt(moved, Inputs.of(moved), values)
    return term.passed(moved, np.hstack([inputs.rate, inputs.force]), values)


def _column(change: np.ndarray) -> Column:
    """The channels that change beyond what rounding leaves."""
    size = np.fmax.reduce(np.abs(change), axis=0, initial=0.0)
    triads = np.repeat([np.nanmax(size[:3]), np.nanmax(size[3:])], 3)
    return {c: change[:, c] for c in EVERY if size[c] > NUMERICAL_ZERO * triads[c] > 0.0}


def _single(columns: Sequence[Column]) -> Iterator[Column]:
    """Columns in single precision, of which a long recording has hundreds."""
    for column in columns:
        yield {channel: signal.astype(np.float32) for channel, signal in column.items()}


def candidates_of(
    terms: Sequence[Term], motion: Motion
) -> tuple[tuple[Candidate, ...], tuple[Column, ...]]:
    """The candidates of some terms, whole and in parts, and the columns they share.

    A term that says at what `time` it acts is tried at STEP_TIMES times, which are proposed later;
    `bias_random_walk` and its smoother relatives are random drifts.
    """
    variants = [variant for term in terms for variant in _variants(term, motion)]
    candidates: list[Candidate] = []
    columns: list[Column] = []
    for number, variant in enumerate(variants):
        own = columns_of(variant, motion)
        term = replace(variant, variant=number)
        if isinstance(term, UnlistedForm):
            candidates.extend(_unlisted(term, own, len(columns)))
        else:
            for part in parts_of(own):
                members = tuple(len(columns) + p for p in part)
                candidates.append(Candidate(term, members, part, 1))
        columns.extend(_single(own))
    for drifts in (_bias_drifts(terms), _scale_factor_drifts()):
        candidates.extend(_random_drifts(drifts, len(columns), len(variants)))
        columns.extend(_single(candidates[-1].term.columns(motion, Inputs.of(motion))))
    names = [(candidate.name, candidate.unlisted) for candidate in candidates]
    counted = (replace(one, trials=names.count((one.name, one.unlisted))) for one in candidates)
    return tuple(counted), tuple(columns)


def with_nuisances(candidates: Sequence[Candidate], names: Sequence[str]) -> list[Candidate]:
    """The candidates, the first of each of some names a nuisance of every model."""
    first: dict[str, Candidate] = {}
    for one in candidates:
        if one.name in names:
            first.setdefault(one.name, one)
    return [replace(one, nuisance=first.get(one.name) is one) for one in candidates]


def searched_by_name(candidates: Sequence[Candidate]) -> list[Candidate]:
    """With one form of the low-pass only: near nothing the others are delays too, or delays of
    each triad, that may not be negative, and would only stand in the way of delays. They are
    compared with what was found.
    """
    return [
        one for one in candidates
        if one.name != BANDWIDTH.name or one.term.parameters == BANDWIDTH.parameters
    ]  # fmt: skip


def plausible_half_ranges(candidates: Sequence[Candidate], count: int) -> np.ndarray:
    """(count,) half of each parameter's plausible range; infinite where nothing is known of it."""
    half = np.full(count, np.inf)
    for candidate in candidates:
        if candidate.prior is None and not candidate.known:
            for p, q in zip(candidate.members, candidate.own, strict=True):
                low, high = candidate.term.parameters[q].plausible
                half[p] = 0.5 * (high - low)
    return half


def is_instant(term: Term) -> bool:
    """Whether its only shape is the time at which something happens."""
    return [shape.name for shape in term.shapes] == ["time"]


def _variants(term: Term, motion: Motion) -> Iterator[Term]:
    """The term at several times, where its shape is the time at which something happens."""
    if not is_instant(term):
        yield term
        return
    for n in range(STEP_TIMES):
        share = (n + 1.0) / (STEP_TIMES + 1.0)
        yield term.shaped((float(motion.t[0] + share * (motion.t[-1] - motion.t[0])),))


def _bias_drifts(terms: Sequence[Term]) -> Iterator[tuple[Term, Form]]:
    walk = next((term for term in terms if term.time_course == "random walk"), None)
    for number, form in enumerate(BIAS_FORMS):
        if form != WALK or walk is not None:
            drift = slow_drift(walk if form == WALK else None, COSINES)
            yield replace(drift, variant=number), form


def _scale_factor_drifts() -> Iterator[tuple[Term, Form]]:
    for number, form in enumerate(SCALE_FORMS, len(BIAS_FORMS)):
        yield replace(scale_factor_drift(COSINES), variant=number), form


def _random_drifts(
    drifts: Iterable[tuple[Term, Form]], first: int, variant: int
) -> Iterator[Candidate]:
    """Candidates that share the columns of cosines in all channels, COSINES for each.

    first: number of the first column; variant: of the first term.
    """
    for drift, (power, corner) in drifts:
        term = replace(drift, variant=variant + drift.variant)
        for part in (EVERY, *TRIADS, *((c,) for c in EVERY)):
            own = tuple(COSINES * c + k for c in part for k in range(COSINES))
            members = tuple(first + p for p in own)
            for strength in STRENGTHS:
                yield Candidate(term, members, own, 1, Prior(power, strength, corner))


def _unlisted(term: UnlistedForm, columns: Sequence[Column], first: int) -> Iterator[Candidate]:
    """An unlisted form in all its channels and in parts of them; first: number of its column."""
    count = term.per_channel
    channels = [next(iter(columns[p])) for p in range(0, len(columns), count)]
    triads = [tuple(c for c in triad if c in channels) for triad in TRIADS]
    parts = [tuple(channels), *(triad for triad in triads if triad), *((c,) for c in channels)]
    for part in dict.fromkeys(parts):
        own = tuple(count * channels.index(c) + k for c in part for k in range(count))
        members = tuple(first + p for p in own)
        for strength in WEIGHTS:
            yield Candidate(term, members, own, 1, Weights(strength, count))


def parts_of(columns: Sequence[Collection[int]]) -> Iterator[tuple[int, ...]]:
    """All parameters; and, where each reads one channel alone, those of a triad, of a channel.

    columns: the channels of each parameter.
    """
    present = [p for p, column in enumerate(columns) if column]
    if present:
        yield tuple(present)
    if any(len(columns[p]) > 1 for p in present) or len(present) < 2:
        return
    by_channel: dict[int, list[int]] = {}
    for p in present:
        by_channel.setdefault(next(iter(columns[p])), []).append(p)
    triads = [[p for c in triad for p in by_channel.get(c, [])] for triad in TRIADS]
    parts = [tuple(triad) for triad in triads if all(triads)]
    parts += [tuple(some) for some in by_channel.values() if len(by_channel) > 1]
    yield from dict.fromkeys(part for part in parts if len(part) < len(present))
