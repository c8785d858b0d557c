"""Candidates: terms of the catalogue and empirical ones, as columns of a design matrix."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.fft import rfft, rfftfreq

from tasks.explain.explanation import ACCELS, EVERY, GYROS, TRIADS, UNNAMED
from tasks.explain.noise import (
    ChannelResidual,
    Noise,
    at_blocks,
    in_band,
    in_time,
    padded_length,
    weighted,
)
from tasks.explain.search.design import BandedDesign, ChannelDesign, residuals, with_columns
from tasks.explain.search.empirical import (
    SINUSOIDS,
    lagged,
    others,
    regression_term,
    scale_factor_drift,
    slow_drift,
    tilt_columns,
)
from tasks.model.fit import inverse
from tasks.model.term import STILL, Column, G, Inputs, Parameter, SensorTerm, Term, turned
from tasks.model.terms.electronics import BANDWIDTH
from tasks.model.terms.hysteresis import faded, last_peak, last_sign, stopped
from tasks.motion.samples import bridged, first_order_lag
from tasks.motion.whole import Motion
from tasks.words import message

# Kinds of behaviour as random functions of their own drive: forms that no publication lists.
#
# A hysteresis is a sum of plays and relays of several widths and of relaxations, which remember
# rate, angle or specific force, of the own axis or of any; a non-linearity a function of the own
# input that bends at many places; a rectification one of the vibration and of the speeds that make
# it; a fixture gives way by a function of attitude or speed; a late temperature, or the heat of
# turning, is a distribution of lags. Each weight is normal about zero, of one variance in a
# kind: a Gaussian process of the drive, whose weights the evidence integrates out (Preisach's and
# Prandtl's operators with random weights; C. E. Rasmussen and C. K. I. Williams, Gaussian
# Processes for Machine Learning, 2006, 2.7). Functions of what drives a memory that remember
# nothing compete with it without a name: a memory is what none of them explains as well.

SHARES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7)  # of the largest drive: radii of plays
# Of the largest rate: slower turns are not remembered.
FAST = (0.05, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85)
ANGLES = (0.03, 0.1, 0.3, 1.0, 3.0)  # rad
FORGOTTEN = (6.0, 20.0, 60.0)  # s
RELAXING = (2.0, 6.0, 20.0, 60.0, 200.0)  # s
LEVELS = (-0.75, -0.3, 0.3, 0.75)  # of the largest specific force: thresholds of relays
BENDS = np.arange(-0.9, 0.95, 0.15)  # of the largest input
SPEEDS = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7)  # of the largest rate: where a rectification bends
OWN_SPEEDS = (0.0, 0.3, 0.6)
LAGS = (8.0, 20.0, 45.0, 90.0, 180.0, 400.0, 900.0)  # s
HEAT_LAGS = (20.0, 45.0, 90.0, 180.0, 400.0)  # s
FAST_HEATS = 0.4  # of the largest rate
BENT_LAGS = (45.0, 180.0)  # s
GIVING_WAY = (0.3, 1.0, 2.5)  # K: radii of plays
# A table shakes more the faster it turns; the air is warmer before the unit is.
OF_SHAKING, OF_HEATING = ("ω_i²", "|ω_j|", "ω⁴"), ("lag(ω²)", "lag(|ω|)")
OF_TEMPERATURE = ("air_temperature",)
OF_ATTITUDE = ("f_j·f_k", "f_i·f_j", "f_j²")
FEW = 0.5  # K: a smaller change of temperature shows no lag
LITTLE = 1e-3  # V: a smaller change of supply shows no bend
Bank = Callable[[Motion, Inputs, int], list[np.ndarray]]


@dataclass(frozen=True)
class Behaviour:
    """A kind of behaviour in the channels of a triad, or of both.

    name: of the catalogue, for all of its forms. bank: the columns of a channel. empirical: what an
    empirical term follows that is a form of it, in these channels. shared: the bank is the same for
    all of them.
    """

    kind: str
    name: str
    family: str
    channels: tuple[int, ...]
    bank: Bank
    empirical: tuple[str, ...] = ()
    shared: bool = False


def behaviours(motion: Motion) -> Iterator["UnlistedForm"]:
    """A term for each kind of behaviour that a recording can show."""
    inputs = Inputs.of(motion)
    for one in _possible(motion):
        yield _term(one, len(one.bank(motion, inputs, one.channels[0])))
    if turned(motion):
        yield _giving_fixture(motion, inputs)


def _possible(motion: Motion) -> Iterator[Behaviour]:
    if turned(motion):
        memory = partial(Behaviour, "hysteresis", "hysteresis", "memory")
        yield memory(GYROS, _memories_of_rate, ("lag(ω)",))
        yield memory(ACCELS, _memories_of_force, ("lag(f)",))
        yield memory(ACCELS, _memories_of_turns, shared=True)
        yield memory(GYROS, _memories_of_attitude, ("lag(f)",), shared=True)
        for triad in TRIADS:
            yield Behaviour("attitude", UNNAMED, UNNAMED, triad, _of_attitude, OF_ATTITUDE)
        yield Behaviour("other rates", UNNAMED, UNNAMED, GYROS, _of_other_rates, ("|ω_j|", "ω_j²"))
        yield Behaviour("non-linearity", "gyro_scale_nonlinearity", "gyro", GYROS, _bent)
        yield Behaviour(
            "angular acceleration", "gyro_angular_acceleration", "gyro", GYROS, _accelerated,
            ("|ω̇|",),
        )  # fmt: skip
        yield Behaviour(
            "rectification", "vibration_rectification", "accelerometer", ACCELS, _shaken, OF_SHAKING
        )
        yield Behaviour("heating", UNNAMED, UNNAMED, EVERY, _heated, OF_HEATING, True)
    yield Behaviour("non-linearity", "accel_nonlinearity", "accelerometer", ACCELS, _bent)
    if _varies(motion, "temperature", FEW):
        yield Behaviour(
            "late temperature", "temperature_bias", "environment", EVERY, _late, OF_TEMPERATURE,
            shared=True,
        )  # fmt: skip
    if _varies(motion, "supply_voltage", LITTLE):
        yield Behaviour(
            "supply", "supply_sensitivity", "environment", EVERY, _supplied, shared=True
        )


def _varies(motion: Motion, key: str, least: float) -> bool:
    """Whether something recorded changes by more than `least`."""
    recorded = motion.recorded.get(key)
    return recorded is not None and float(np.nanmax(recorded) - np.nanmin(recorded)) > least


def _term(one: Behaviour, count: int) -> "UnlistedForm":
    title = message(f"explain-unlisted-{one.kind.replace(' ', '-')}")
    term = regression_term(one.kind, title, one.channels, count, one.bank, one.shared)
    return UnlistedForm(
        one.name, one.family, "sensor", "Σₖ wₖ·sₖ, wₖ normal", "random function of its own drive",
        term.parameters, own_title=title, reads=term.reads, form_of=one, per_channel=count,
    )  # fmt: skip


@dataclass(frozen=True)
class UnlistedForm(SensorTerm):
    """A kind of behaviour in a form that no publication lists. per_channel: number of columns."""

    form_of: Behaviour = field(kw_only=True)
    per_channel: int = field(kw_only=True)


def _share(values: np.ndarray) -> np.ndarray:
    """(n, …) of the largest; zero where it is not known."""
    known = np.nan_to_num(values)
    return np.asarray(known / max(float(np.abs(known).max(initial=0.0)), 1e-9))


def _memories_of_rate(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    rate = motion.rate[:, channel]
    top = float(np.abs(np.nan_to_num(motion.rate)).max())
    return [
        *(stopped(rate, share * top) for share in SHARES),
        *(last_sign(rate, max(STILL, share * top)) for share in FAST),
        *(lagged(rate, motion.t, seconds) for seconds in RELAXING),
        last_peak(rate, STILL),
        *_memories_of_turn(motion, channel),
    ]


def _memories_of_turn(motion: Motion, axis: int) -> list[np.ndarray]:
    """Of the angle turned about an axis, and of the last turn's sense."""
    rate = motion.rate[:, axis]
    angle = np.cumsum(np.nan_to_num(rate)) * motion.interval
    return [
        *(stopped(angle, radius) for radius in ANGLES),
        last_sign(rate, STILL),
        *(faded(rate, motion.t, seconds, STILL) for seconds in FORGOTTEN),
    ]


def _memories_of_turns(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    return [one for axis in range(3) for one in _memories_of_turn(motion, axis)]


def _memories_of_force(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    force = inputs.force[:, channel % 3]
    change, still = np.gradient(force, motion.t), 1e-3 * G
    levels = [G * level for level in LEVELS]
    return [
        *(stopped(force, share * G) for share in SHARES[1:]),
        *(_relay(force, up, down) for up in levels for down in levels if up > down),
        last_sign(change, still),
        *(faded(change, motion.t, seconds, still) for seconds in FORGOTTEN),
        *(lagged(force, motion.t, seconds) / G for seconds in RELAXING),
    ]


def _memories_of_attitude(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    return [one for axis in range(3) for one in _memories_of_force(motion, inputs, axis)]


def _of_attitude(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Functions that remember nothing of the specific force along the other axes; of a gyro along
    its own, too.
    """
    force = inputs.force / G
    axes = range(3) if channel in GYROS else others(channel)
    bent = [np.abs(force[:, j] - bend) for j in axes for bend in BENDS[::2]]
    return [*bent, *(force[:, j] * force[:, (j + 1) % 3] for j in range(3))]


def _of_other_rates(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Functions of the other axes' rates that remember nothing."""
    rate = _share(inputs.rate)
    return [np.abs(rate[:, j] - bend) for j in others(channel) for bend in BENDS[::2]]


def _accelerated(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Functions of the angular acceleration about each axis."""
    size = _share(motion.acceleration)
    return [
        one
        for j in range(3)
        for one in (size[:, j], np.abs(size[:, j]), size[:, j] ** 2, size[:, j] ** 3)
    ]


def _relay(drive: np.ndarray, up: float, down: float) -> np.ndarray:
    """(n,) 1 since the drive last rose above `up`, −1 since it last fell below `down`; 0 before."""
    rows = np.arange(len(drive))
    raised = np.maximum.accumulate(np.where(drive > up, rows, -1))
    fell = np.maximum.accumulate(np.where(drive < down, rows, -1))
    return np.sign(raised - fell).astype(float)


def _bent(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    x = _share(inputs.rate if channel in GYROS else inputs.force)[:, channel % 3]
    return [np.abs(x - bend) for bend in BENDS]


def _shaken(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    shares = np.abs(_share(motion.rate))
    speed = _share(np.linalg.norm(shares, axis=1))
    power = _share(motion.recorded.get("vibration", np.zeros(len(speed))))
    return [
        *(np.maximum(speed - least, 0.0) for least in SPEEDS),
        *(np.maximum(shares[:, j] - least, 0.0) for j in range(3) for least in OWN_SPEEDS),
        power, np.sqrt(power), power / (power + 0.2),
    ]  # fmt: skip


def _heated(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Of what turning heats: of its power, and of that of fast turns alone."""
    speed = _share(np.linalg.norm(np.nan_to_num(motion.rate), axis=1))
    loads = speed**2, np.maximum(speed - FAST_HEATS, 0.0)
    return [first_order_lag(load, motion.interval, tau) for load in loads for tau in HEAT_LAGS]


def _late(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Deviations from the first temperature, K: what was in balance before."""
    known = bridged(motion.recorded["temperature"][:, None])[:, 0]
    above = known - known[0]
    late = partial(first_order_lag, above, motion.interval)
    return [
        *(late(seconds) for seconds in LAGS),
        *(late(seconds) ** 2 / 10.0 for seconds in BENT_LAGS),
        *(radius * stopped(late(LAGS[0]), radius) for radius in GIVING_WAY),
        *(np.abs(_centred(known) - bend) for bend in BENDS[::2]),
    ]


def _supplied(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    volts = _centred(motion.recorded["supply_voltage"])
    return [volts, *(np.abs(volts - bend) for bend in BENDS[::2])]


def _centred(recorded: np.ndarray) -> np.ndarray:
    """(n,) from −1 to 1 over the range of something recorded."""
    known = bridged(recorded[:, None])[:, 0]
    low, high = float(known.min()), float(known.max())
    return (2.0 * known - low - high) / (high - low)


def _giving_way(motion: Motion, inputs: Inputs) -> list[np.ndarray]:
    """Functions of attitude, and of the speed of turning."""
    up, speed = np.nan_to_num(motion.up), np.linalg.norm(_share(motion.rate), axis=1)
    return [
        *(up[:, j] for j in range(3)),
        *(np.abs(up[:, j] - bend) for j in range(3) for bend in BENDS[::3]),
        *(np.maximum(_share(speed) - least, 0.0) for least in SPEEDS),
    ]


def _giving_fixture(motion: Motion, inputs: Inputs) -> "UnlistedForm":
    """A fixture that turns by functions of attitude and speed."""
    count = 3 * len(_giving_way(motion, inputs))

    def columns(motion: Motion, inputs: Inputs, at: tuple[float, ...]) -> tuple[Column, ...]:
        return tuple(
            one for regressor in _giving_way(motion, inputs)
            for one in tilt_columns(regressor, motion, inputs)
        )  # fmt: skip

    behaviour = Behaviour("fixture", "structural_compliance", "motion", EVERY, _of_attitude)
    parameters = tuple(Parameter(f"tilt_{k}", "tilt", "rad", "rad", (-0.01, 0.01))
                       for k in range(count))  # fmt: skip
    return UnlistedForm(
        behaviour.name, behaviour.family, "sensor", "φ = Σₖ wₖ·sₖ, wₖ normal",
        "random function of its own drive", parameters,
        own_title=message("explain-unlisted-fixture"), reads=columns, form_of=behaviour,
        per_channel=count,
    )  # fmt: skip


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


# Proposes instants at which a bias may have stepped, and periods of recurring contributions.
#
# A grid of times or periods fine enough to miss nothing would have hundreds of columns. The
# whitened residual shows for all of them at once how much each would gain; the best few become
# the shapes of the candidates.

TIME, PERIOD = "time", "period"
STEP_DISTANCE = 15.0  # s between two proposed steps
CORRELATED = 5.0  # s within which two steps look alike in a noise that drifts
STEP_GRID = 24  # times at which a step's own size is computed; between them it is smooth
MIN_PERIODS = 4.0  # of a sinusoid in a run
MAX_FREQUENCY = 1.0  # Hz
OVERSAMPLING = 4  # points of the spectrum for each independent one


def with_proposed_shapes(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    noises: Sequence[Noise],
    selected: Sequence[Candidate] = (),
    beside: Sequence[Candidate] | None = None,
) -> tuple[BandedDesign, list[Candidate]]:
    """Design and candidates with the best times for steps and the best periods for sinusoids.

    selected: candidates that stay as they are. beside: the candidates beside which the others are
    proposed; the selected ones if not given.
    """
    left = residuals(design, members_of(selected if beside is None else beside), noises)
    terms = _proposed_terms(design, candidates, noises, selected, left)
    span = len(design.blocks.t) / design.blocks.rate
    columns, updated = {}, []
    for candidate in candidates:
        term = terms.get(candidate.term.key)
        if term is None:
            updated.append(candidate)
            continue
        fresh = columns_of(term, design.blocks.motion)
        columns.update({p: fresh[q] for p, q in zip(candidate.members, candidate.own, strict=True)})
        independent = span / CORRELATED if _shape(term) == TIME else span * MAX_FREQUENCY
        updated.append(replace(candidate, term=term, shape_trials=independent))
    return with_columns(design, columns), updated


def _shape(term: Term) -> str:
    """The name of its only shape; nothing where it has none or several."""
    return term.shapes[0].name if len(term.shapes) == 1 else ""


def _proposed_terms(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    noises: Sequence[Noise],
    selected: Sequence[Candidate],
    left: Sequence[ChannelResidual],
) -> Mapping[tuple[str, int], Term]:
    """The terms with a time or a period, but those selected, with their proposed shapes, by key."""
    steps, sinusoids = _gains(design, left, noises)
    held = {candidate.term.key for candidate in selected}
    shapes: dict[tuple[str, tuple[int, ...]], list[float]] = {}
    terms: dict[tuple[str, int], Term] = {}
    for candidate in candidates:
        shape = _shape(candidate.term)
        if shape not in (TIME, PERIOD) or candidate.term.key in held | set(terms):
            continue
        channels = tuple(sorted({c for p in candidate.members for c in design.columns[p]}))
        if (shape, channels) not in shapes:
            gain = (steps if shape == TIME else sinusoids)[list(channels)].sum(axis=0)
            best = _best_times if shape == TIME else _best_periods
            shapes[shape, channels] = best(gain, design)
        if shapes[shape, channels]:
            terms[candidate.term.key] = candidate.term.shaped((shapes[shape, channels].pop(0),))
    return terms


def _gains(
    design: BandedDesign, left: Sequence[ChannelResidual], noises: Sequence[Noise]
) -> tuple[np.ndarray, np.ndarray]:
    """Chi-squared of a step at each time (6, n) and of a sinusoid of each frequency (6, m)."""
    steps = np.zeros((len(left), len(design.blocks.t)))
    sinusoids = np.zeros((len(left), len(_frequencies(design))))
    for c, channel in enumerate(design.channels):
        if channel is not None:
            score = _score(design, c, left[c], noises[c])
            steps[c] = _step_gains(design, c, channel, score, noises[c])
            sinusoids[c] = _sinusoid_gains(design, c, score, noises[c])
    return steps, sinusoids


def _score(design: BandedDesign, c: int, left: ChannelResidual, noise: Noise) -> np.ndarray:
    """(n,) residual divided by the noise's covariance: its product with a column is a score."""
    weight = design.blocks.weight[:, c]
    whitened = left.coefficients / noise.of_coefficients(design.bands)
    padded = padded_length(len(design.blocks.compared))
    return at_blocks(in_time(whitened, padded)[None], design.blocks)[0] * weight


def _step_gains(
    design: BandedDesign, c: int, channel: ChannelDesign, score: np.ndarray, noise: Noise
) -> np.ndarray:
    """(n,) chi-squared that a step at each time would gain in one channel."""
    count = len(score)
    root = np.sqrt(noise.of_coefficients(design.bands))
    at = np.linspace(0.02 * count, 0.98 * count, STEP_GRID).astype(int)
    rows = np.arange(count)
    later = [np.where(rows >= start, 1.0, 0.0) for start in at]
    stack = weighted(later, design.blocks.weight[:, c], design.blocks)
    steps = in_band(stack, design.blocks) / root
    base = channel.base / root
    shared = steps @ base.T
    size = (steps**2).sum(axis=1)
    size = size - np.einsum("kb,bd,kd->k", shared, inverse(base @ base.T), shared)
    summed = np.cumsum(score[::-1])[::-1]
    known = np.interp(rows, at, np.maximum(size, 1e-300))
    return np.asarray(summed**2 / known)


def _sinusoid_gains(design: BandedDesign, c: int, score: np.ndarray, noise: Noise) -> np.ndarray:
    """(m,) chi-squared that a sinusoid of each frequency would gain in one channel."""
    power = np.abs(rfft(score, OVERSAMPLING * len(score))) ** 2
    frequency = _frequencies(design)
    weight = float((design.blocks.weight[:, c] ** 2).sum())
    variance = noise.variance(np.maximum(frequency, frequency[1]))
    return np.asarray(2.0 * power * variance / max(weight, 1e-300))


def _frequencies(design: BandedDesign) -> np.ndarray:
    return np.asarray(rfftfreq(OVERSAMPLING * len(design.blocks.t), 1.0 / design.blocks.rate))


def _best_times(gain: np.ndarray, design: BandedDesign) -> list[float]:
    t, edge = design.blocks.t, len(gain) // 50
    inner = np.zeros_like(gain)
    inner[edge : len(gain) - edge] = gain[edge : len(gain) - edge]
    best = _best(inner, STEP_TIMES, lambda k: np.abs(t - t[k]) < STEP_DISTANCE)
    return [float(t[k]) for k in best]


def _best_periods(gain: np.ndarray, design: BandedDesign) -> list[float]:
    frequency = _frequencies(design)
    span = len(design.blocks.t) / design.blocks.rate
    inner = np.where((frequency > MIN_PERIODS / span) & (frequency < MAX_FREQUENCY), gain, 0.0)
    best = _best(inner, SINUSOIDS, lambda k: np.abs(frequency - frequency[k]) < 2.0 / span)
    return [float(1.0 / frequency[k]) for k in best]


def _best(gain: np.ndarray, count: int, near: Callable[[int], np.ndarray]) -> list[int]:
    """Where gain (n,) is largest, at most `count` times, nothing near (n,) bool another."""
    found: list[int] = []
    left = gain.copy()
    for _ in range(count):
        best = int(np.argmax(left))
        if left[best] <= 0:
            break
        found.append(best)
        left[near(best)] = 0.0
    return found
