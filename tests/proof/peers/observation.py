"""A recording as every peer sees it: blocks, the standard's model fitted, noise, library, folds.

The inputs, their block means and the folds are those of `explain` itself, so that nobody has
better ones.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from scipy.fft import dct, idct, next_fast_len
from scipy.optimize import nnls

from schemas.discrepancy import Dimension
from schemas.recording import ACCEL, GYRO, Recording
from tasks.explain.evidence.cells import FOLDS, fold_cells
from tasks.explain.inputs.blocks import Blocks, block_means, full_rate
from tasks.model.term import Inputs
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion

# Which block of time each row of the unit's stream falls into: the one place that says so.
#
# Predictions are kept and compared as means over these blocks, those that
# `tasks.explain.inputs.blocks` makes at the same rate.

BLOCK_RATE = 25.0  # Hz


def block_numbers(t: np.ndarray) -> np.ndarray:
    """(n,) the block of each row, from its time t (n,) s."""
    since = t - t[0]
    own = 1.0 / max(float(np.median(np.diff(t))), 1e-9)
    step = max(1, round(own / BLOCK_RATE))
    return np.asarray(((since + 0.5 / own) * own / step).astype(int))


def means_of_blocks(courses: np.ndarray, numbers: np.ndarray, count: int) -> np.ndarray:
    """(count, k) means of courses (n, k); NaN where a row of a block is, or where there is none."""
    rows = np.bincount(numbers, minlength=count)[:count]
    sums = np.column_stack([np.bincount(numbers, c, count)[:count] for c in courses.T])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / rows[:, None])


# The generic library: powers and products of what was commanded and recorded beside the unit.
#
# Column names are formulas: factors parted by “·”, squares “²”, cubes “³”. ω: rate, u: the upward
# vertical, n: North (unit vectors in the body), α: angular acceleration, T and Ṫ: the unit's
# temperature and its rate (the room's where the unit gives none), V: supply, t: time.

AXES = "xyz"
RECORDED = {"supply_voltage": "V", "humidity": "H", "pressure": "p", "vibration": "vibration"}
SQUARED = ("ω", "u")
WARM_UPS = (60.0, 300.0, 900.0)  # s
LEAST = 1e-9  # spread of a course that says something


def library(motion: Motion) -> dict[str, np.ndarray]:
    """(n,) each: all that a stepwise regression may choose from."""
    columns = polynomial(motion)
    rate = motion.rate
    columns |= {f"|ω_{a}|": np.abs(rate[:, i]) for i, a in enumerate(AXES)}
    columns |= {f"exp(-t/{tau:g})": np.exp(-motion.t / tau) for tau in WARM_UPS}
    return {name: _bridged(series) for name, series in columns.items()}


def polynomial(motion: Motion) -> dict[str, np.ndarray]:
    """The same without what is no polynomial of the inputs: of second degree in rates, vertical,
    temperature, time and supply; cubes of rates and vertical; the rest as it is."""
    inputs = _inputs(motion)
    crossed = {k: v for k, v in inputs.items() if k[0] in "ωuTtV"}
    columns = dict(inputs)
    for a, b in combinations_with_replacement(crossed, 2):
        columns[f"{a}²" if a == b else f"{a}·{b}"] = crossed[a] * crossed[b]
    for name, series in inputs.items():
        if name[0] in SQUARED:
            columns[f"{name}³"] = series**3
    return {name: _bridged(series) for name, series in columns.items()}


def _inputs(motion: Motion) -> dict[str, np.ndarray]:
    return {
        name: series
        for name, series in _every(motion)
        if np.isfinite(series).any() and np.nanstd(series) > LEAST
    }


def _every(motion: Motion) -> Iterator[tuple[str, np.ndarray]]:
    for letter, series in (("ω", motion.rate), ("u", motion.up)):
        yield from ((f"{letter}_{a}", series[:, i]) for i, a in enumerate(AXES))
    recorded = motion.recorded
    own = "temperature" in recorded
    temperature = recorded.get("temperature", recorded.get("air_temperature"))
    if temperature is not None:
        yield "T", _centred(temperature)
    if own:
        yield "Ṫ", recorded["temperature_rate"]
    yield "t", _centred(motion.t)
    for name, symbol in RECORDED.items():
        if name in recorded:
            yield symbol, _centred(recorded[name])
    for letter, series in (("n", motion.north), ("α", motion.acceleration)):
        yield from ((f"{letter}_{a}", series[:, i]) for i, a in enumerate(AXES))


def _centred(series: np.ndarray) -> np.ndarray:
    return np.asarray(series - series[np.isfinite(series)].mean())


def _bridged(series: np.ndarray) -> np.ndarray:
    """Nothing where the motion is not known: those blocks have no weight."""
    return np.nan_to_num(series)


# Noise as engineers state it: angle random walk and bias instability by the Allan variance.
#
# Taken inside the segments only, so that what differs between them is not taken for noise, and as
# a median over them, so that a few bad ones do not count (IEEE Std 952-1997, annex C: white noise
# of density w has σ²(τ) = w/2τ, flicker b/f has σ²(τ) = 2·ln 2·b).

FLICKER = 2.0 * np.log(2.0)
FEWEST = 2  # differences of neighbouring means in a segment
LONGEST = 12  # doublings of a block
EFFICIENCY = 0.64  # of a median beside a mean, 2/π
TRIADS = (slice(0, 3), slice(3, 6))


@dataclass(frozen=True)
class Noise:
    """One-sided density S(f) = white + flicker/f of one channel."""

    white: float
    flicker: float

    def of_mean(self, seconds: np.ndarray, whole: float) -> np.ndarray:
        """Variance of means over some seconds against the level of the whole run (s)."""
        beyond = 1.0 + np.log(np.maximum(whole / seconds, 1.0))
        return np.asarray(self.white / (2.0 * seconds) + self.flicker * beyond)


def noises_of(observed: Blocks, left: np.ndarray) -> tuple[Noise, ...]:
    """Noise of the six channels from what the standard's model leaves, (n, 6).

    The corner between white and flicker noise is common to a triad.
    """
    noises: list[Noise] = []
    for triad in TRIADS:
        ladders = [_ladder(observed, left[:, c], c) for c in range(6)[triad]]
        relative = np.array([variance / max(variance[0], 1e-300) for variance, _ in ladders])
        freedom = np.sum([freedom for _, freedom in ladders], axis=0)
        known = np.isfinite(relative).all(axis=0)
        corner = _corner(relative[:, known].mean(axis=0), freedom[known], observed.rate)
        for variance, _ in ladders:
            level = max(variance[0] * 2.0 / observed.rate, 1e-30)
            level /= 1.0 + corner * FLICKER * 2.0 / observed.rate
            noises.append(Noise(level, corner * level))
    return tuple(noises)


def _ladder(observed: Blocks, left: np.ndarray, channel: int) -> tuple[np.ndarray, np.ndarray]:
    """Allan variance at 1, 2, 4 … blocks and its degrees of freedom: medians over the segments;
    NaN where too few are so long."""
    lengths = 2 ** np.arange(LONGEST)
    found: list[list[float]] = [[] for _ in lengths]
    freedoms = np.zeros(LONGEST)
    for number in range(len(observed.segments)):
        rows = np.flatnonzero((observed.segment == number) & (observed.weight[:, channel] > 0))
        series = left[rows]
        for k, length in enumerate(lengths):
            count = len(series) // length
            if count < FEWEST + 1:
                break
            means = series[: count * length].reshape(count, length).mean(axis=1)
            freedom = max(1.0, 0.67 * (count - 1))  # neighbouring differences share a mean
            typical = (1.0 - 2.0 / (9.0 * freedom)) ** 3  # median of chi-squared over its mean
            found[k].append(float(np.mean(np.diff(means) ** 2) / 2.0 / typical))
            freedoms[k] += freedom
    variance = [np.median(each) if len(each) > FEWEST else np.nan for each in found]
    return np.array(variance), freedoms


def _corner(relative: np.ndarray, freedom: np.ndarray, rate: float) -> float:
    """Frequency (Hz) at which flicker is as dense as white noise, plus its standard error: a
    lucky run must not pass for a unit without flicker."""
    if len(relative) < 3 or not (relative > 0).all():
        return 0.0
    seconds = 2 ** np.arange(len(relative)) / rate
    root = np.sqrt(EFFICIENCY * freedom / 2.0) / relative
    columns = np.column_stack([0.5 / seconds, np.full(len(seconds), FLICKER)]) * root[:, None]
    (white, flicker), _ = nnls(columns, relative * root)
    spread = np.sqrt(np.linalg.inv(columns.T @ columns)[1, 1])
    return float((flicker + spread) / white) if white > 0 else rate


def whitened(courses: np.ndarray, noise: Noise, rate: float) -> np.ndarray:
    """Courses (k, n) whose noise has this density, divided by its root: unit variance."""
    count = courses.shape[1]
    length = int(next_fast_len(count, real=True))
    padded = np.pad(courses, ((0, 0), (0, length - count)), mode="symmetric")
    frequency = np.maximum(np.arange(length), 0.5) * rate / (2.0 * length)
    gain = 1.0 / np.sqrt((noise.white + noise.flicker / frequency) * rate / 2.0)
    flat = dct(padded, type=2, norm="ortho", overwrite_x=True) * gain
    return np.asarray(idct(flat, type=2, norm="ortho", overwrite_x=True)[:, :count])


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


# Few points that stand for a run: means over its dwells, in sectors where attitude turns.

MOST = 320  # points
SECTORS = 8  # of a turn
TURNING = 0.2  # spread of a component of the vertical: a turn, not a tremble
FEWEST_OF_POINT = 5  # blocks of a point
UNLABELLED = 10.0  # s
RELAXATIONS_APART = 4.0  # factor between the time constants that make up flicker


@dataclass(frozen=True)
class Points:
    """number: (n,) point of each block, −1 for none. inputs: (m, d) over their ranges; names: of
    them. time: (m,) s. seconds: (m, 6) of data in each. fold: (m,)."""

    number: np.ndarray
    weight: np.ndarray
    inputs: np.ndarray
    names: tuple[str, ...]
    time: np.ndarray
    seconds: np.ndarray
    fold: np.ndarray

    def mean(self, courses: np.ndarray, channel: int) -> np.ndarray:
        """(m, k) means of courses (n, k) by the weight of a channel's blocks."""
        rows = self.number >= 0
        weight = self.weight[rows, channel] ** 2
        total = np.bincount(self.number[rows], weight, len(self.time))
        sums = [np.bincount(self.number[rows], c * weight, len(self.time)) for c in courses[rows].T]
        return np.asarray(np.column_stack(sums) / np.maximum(total, 1e-300)[:, None])

    def relaxations(self, whole: float) -> np.ndarray:
        """(m, m) covariance of noise 1/f: relaxations whose time constants are spaced evenly in
        their logarithm, from a second to the length of the run (s)."""
        apart = np.abs(self.time[:, None] - self.time)
        taus = RELAXATIONS_APART ** np.arange(np.log(whole) / np.log(RELAXATIONS_APART))
        return np.asarray(np.log(RELAXATIONS_APART) * sum(np.exp(-apart / tau) for tau in taus))


def inputs_of(observation: Observation) -> np.ndarray:
    """(n, d) inputs of δ at the blocks, each over its range; those that vary."""
    return _scaled(observation)[0]


def _scaled(observation: Observation) -> tuple[np.ndarray, tuple[str, ...]]:
    motion = observation.observed.motion
    courses = {f"ω_{a}": motion.rate[:, i] for i, a in enumerate("xyz")}
    courses |= {f"u_{a}": motion.up[:, i] for i, a in enumerate("xyz")}
    courses["t"] = motion.t
    temperature = motion.recorded.get("temperature", motion.recorded.get("air_temperature"))
    if temperature is not None:
        courses["T"] = temperature
    spans = {name: np.nanmax(series) - np.nanmin(series) for name, series in courses.items()}
    kept = {name: series for name, series in courses.items() if spans[name] > 1e-6}
    scaled = [np.nan_to_num(series) / spans[name] for name, series in kept.items()]
    return np.column_stack(scaled), tuple(kept)


def points_of(observation: Observation) -> Points:
    """The points of a recording; a run without labels is cut into stretches of UNLABELLED."""
    observed = observation.observed
    inputs, names = _scaled(observation)
    number = _numbered(_dwells(observation), observed.motion.up)
    rows, m = number >= 0, int(number.max()) + 1
    count = np.bincount(number[rows], minlength=m)

    def mean(series: np.ndarray) -> np.ndarray:
        return np.asarray(np.bincount(number[rows], series[rows], m) / count)

    weights = [np.bincount(number[rows], w[rows] ** 2, m) for w in observed.weight.T]
    return Points(
        number=number,
        weight=observed.weight,
        inputs=np.column_stack([mean(series) for series in inputs.T]),
        names=names,
        time=mean(observed.t),
        seconds=np.maximum(np.column_stack(weights) / observed.rate, 1e-9),
        fold=np.round(mean(observation.fold)).astype(int),
    )


def _dwells(observation: Observation) -> np.ndarray:
    """(n,) the dwell of each block; −1 in moves and where nothing is known."""
    observed = observation.observed
    usable = (observed.weight[:, list(observation.used)] > 0).all(axis=1)
    held = np.array([each.kind != "transition" for each in observed.segments] + [False])
    dwell = np.where(usable & held[observed.segment], observed.segment, -1)
    if (dwell >= 0).any():
        return dwell
    return np.where(usable, (observed.t // UNLABELLED).astype(int), -1)


def _numbered(dwell: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(n,) the point of each block: its dwell, and the sector of the turn; −1 for none."""
    numbers = np.unique(dwell[dwell >= 0])
    sectors = int(np.clip(MOST // max(len(numbers), 1), 1, SECTORS))
    label = np.full(len(dwell), -1)
    for k in numbers:
        rows = np.flatnonzero(dwell == k)
        label[rows] = k * SECTORS + _sector(up[rows], sectors)
    _, place, counts = np.unique(label, return_inverse=True, return_counts=True)
    kept = (label >= 0) & (counts[place] >= FEWEST_OF_POINT)
    number = np.full(len(dwell), -1)
    number[kept] = np.unique(label[kept], return_inverse=True)[1]
    return number


def _sector(up: np.ndarray, sectors: int) -> np.ndarray:
    """(n,) sector of the turn that the vertical (n, 3) makes in the body; 0 where it is still."""
    moved = up - up.mean(axis=0)
    _, spread, plane = np.linalg.svd(moved, full_matrices=False)
    if sectors < 2 or spread[min(1, len(spread) - 1)] < TURNING * np.sqrt(len(up)):
        return np.zeros(len(up), int)
    angle = np.arctan2(moved @ plane[1], moved @ plane[0])
    return np.asarray(np.floor((angle + np.pi) / (2.0 * np.pi) * sectors).astype(int) % sectors)


# What a peer answers, in the same form for all of them.

UNNAMED = "unnamed"
SLIGHT = 0.05  # of the strongest evidence


@dataclass(frozen=True)
class Located:
    """Where a peer sees a mismatch. strength: its own statistic there."""

    channel: str
    dimension: Dimension
    description: str
    strength: float
    segments: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeldOut:
    """Segments that the fit did not see, in whitened units: root of the ratio of squared misfits
    after and before, and the log-likelihood gained, nats."""

    rms_ratio: float = 1.0
    gain: float = 0.0


@dataclass(frozen=True)
class Answer:
    """statistic: of the strongest mismatch; above the threshold it is a detection.

    names: of the catalogue or `unnamed`, the clearest first. found: (n, 6) predicted readings at
    the blocks; None: the standard's model as it is.
    """

    statistic: float
    threshold: float
    located: tuple[Located, ...] = ()
    names: tuple[str, ...] = ()
    found: np.ndarray | None = None
    held_out: HeldOut = HeldOut()

    @property
    def detected(self) -> bool:
        return bool(self.statistic > self.threshold)


def in_order(names: Sequence[tuple[float, str]]) -> tuple[str, ...]:
    """Each name once, by falling evidence (of the order of chi-squared).

    What has less than SLIGHT of the strongest's is a fit's residue more often than another
    cause, and gets no name.
    """
    ranked = sorted(names, key=lambda pair: -pair[0])
    return tuple(dict.fromkeys(
        name if size >= SLIGHT * ranked[0][0] else UNNAMED for size, name in ranked
    ))  # fmt: skip
