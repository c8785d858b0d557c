"""The residual after all findings, relative to the noise of sensor and reference.

The sensor's noise is read off short stretches at rest, where no model is needed, and not off what
a model leaves: a model that lacks something would call noise what it lacks. The reference's is its
own account of itself; beyond the band in which poses tell the motion nothing is held against them.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.signal import welch
from scipy.stats import chi2

from tasks.explain.evidence.cells import scatter_cells
from tasks.explain.evidence.evidence import Evidence, FindingGroup, fitted_columns
from tasks.explain.explanation import ACCELS, COVERAGE, UNNAMED, Finding, Refusal, RefusalKind
from tasks.explain.inputs.blocks import VIBRATING, FullRate
from tasks.explain.noise import equations_of
from tasks.model.fit import inverse
from tasks.model.term import Inputs, Parameter, parameters_of
from tasks.model.terms.electronics import BANDWIDTH
from tasks.model.terms.gyro import THRESHOLD
from tasks.motion.samples import in_blocks, noise_by_differences
from tasks.motion.whole import Motion
from tasks.words import message
from tasks.words.numbers import percent, plain

WINDOW = 2.0  # s: noise is what scatters within, slower changes are counted as mismatch
STILL = 0.02  # rad/s
MIN_WINDOWS = 5  # at rest; with fewer the noise is that of neighbouring samples
MIN_ROWS = 8  # of a window
LEAST = 0.1  # of the noise that is usual in a triad
ORDER = 4  # of the differences in which motion leaves next to nothing
KNOWN_WITHIN = 0.1  # share of its power within which the noise at rest is known
NEAR_NOISE = 2.0  # chi-squared per degree of freedom below which less is left than noise has
REFERENCE_KNOWN = 10.0  # times its own account: the power that a reference's noise may have
BAND = (0.1, 0.9)  # quantiles of the power above noise between which a band is told
SPECTRUM = 20.0  # s of one spectrum


@dataclass(frozen=True)
class LeftOver:
    """Residuals of the readings from the standard's model and from the model with all findings.

    before, after: (n, 6) squares of the residuals over the noise, NaN where unknown. masked: (n, 6)
    bool, readings that are not used. noise: (n, 6) variance of a mean over `rows` readings, of the
    sensor at rest and of the reference together; reference: (n, 6) the reference's part of it.
    rows: as many as the reference resolves, one for an exact reference. rounding: (6,) variance of
    what rounding adds where noise does not dither: no mean makes it smaller.
    """

    before: np.ndarray
    after: np.ndarray
    masked: np.ndarray
    noise: np.ndarray
    reference: np.ndarray
    rows: int
    rounding: np.ndarray

    @classmethod
    def of(
        cls, full: FullRate, nominal: np.ndarray, found: np.ndarray, masked: np.ndarray
    ) -> "LeftOver":
        """nominal, found: (n, 6) predicted readings without and with all findings."""
        own = rest_noise(full, np.where(masked, np.nan, full.readings - found)) * _vibration(full)
        interval, rows = full.motion.interval, 1
        if (tracking := full.reference_noise.tracking) is not None:
            rows = max(1, round(0.5 / tracking.edge / interval))
        # What smoothing loses of the motion is as large as the noise that it lets through.
        reference = (1.0 + (rows > 1)) * full.reference_noise.variance(full.motion, rows * interval)
        noise = own / rows + reference
        rounding = np.where(full.dithered, 0.0, full.steps**2 / 12.0)
        empty = cls(np.empty(0), np.empty(0), masked, noise, reference, rows, rounding)
        return replace(
            empty,
            before=empty.squares(full.readings - nominal),
            after=empty.squares(full.readings - found),
        )

    def squares(self, residual: np.ndarray) -> np.ndarray:
        """(n, 6) squares of means of a residual (n, 6) over the noise, each at all of its rows."""
        if self.rows > 1:
            residual = block_means_at_rows(residual, self.rows)
        return np.asarray(residual**2 / self.noise)

    @property
    def _used(self) -> np.ndarray:
        return np.isfinite(self.after) & ~self.masked

    @property
    def chi2_per_degree(self) -> np.ndarray:
        """(6,) after all findings; NaN where a channel was not recorded."""
        total, rows = np.where(self._used, self.after, 0.0).sum(axis=0), self._used.sum(axis=0)
        return np.divide(total, rows, out=np.full(len(rows), np.nan), where=rows > 0)

    def beyond_reference(self, known: float) -> np.ndarray:
        """(6,) chi-squared per degree of freedom that stays were the reference's noise power
        `known` times its own account of itself; NaN where a channel was not recorded.
        """
        lower = self.noise / (self.noise + (known - 1.0) * self.reference)
        return replace(self, after=self.after * lower).chi2_per_degree

    @property
    def removed(self) -> float:
        """Chi-squared that all findings remove."""
        return max(0.0, float(np.nansum(self.before - self.after)))

    @property
    def remaining_by_channel(self) -> np.ndarray:
        """(6,) chi-squared that is left above the noise, as far as that is known."""
        rows = self._used.sum(axis=0)
        above = np.nan_to_num(self.chi2_per_degree) - 1.0 - KNOWN_WITHIN
        return np.asarray(rows * np.maximum(above, 0.0))

    @property
    def rounded_by_channel(self) -> np.ndarray:
        """(6,) chi-squared of what rounding adds."""
        return np.asarray(np.where(self._used, self.rounding / self.noise, 0.0).sum(axis=0))

    @property
    def remaining(self) -> float:
        """Chi-squared that is left above the noise in all channels."""
        return float(self.remaining_by_channel.sum())

    @property
    def explained_share(self) -> float:
        """The explained share of the mismatch above noise; one if there is none."""
        mismatch = self.removed + self.remaining
        return self.removed / mismatch if mismatch > 0.0 else 1.0


def block_means_at_rows(values: np.ndarray, rows: int) -> np.ndarray:
    """Means (n, k) of values (n, k) over `rows` of them, at each row; NaN where one is NaN."""
    starts = np.arange(0, len(values), rows)
    counts = np.diff(np.append(starts, len(values)))
    means = np.add.reduceat(values, starts, axis=0) / counts[:, None]
    return np.asarray(np.repeat(means, counts, axis=0))


def rest_noise(full: FullRate, residual: np.ndarray) -> np.ndarray:
    """(6,) variance of a sample about its mean over a short time at rest.

    Of the readings or of the residual of a model (n, 6), whichever is smaller: the readings contain
    lines and steps that were found, the residual the noise of the reference. For a unit that never
    rests, the white noise of its readings.
    """
    rate = np.linalg.norm(full.motion.rate, axis=1)
    rows = max(MIN_ROWS, round(WINDOW / max(full.motion.interval, 1e-9)))
    still = in_blocks(rate, rows).max(axis=1, initial=0.0) < STILL
    variance = np.ones(len(full.rest_variance))
    for channel in range(len(variance)):
        readings = full.readings[:, channel]
        usual = [
            _usual_variance(in_blocks(values, rows)[still])
            for values in (readings, residual[:, channel])
        ]
        if np.isfinite(usual).any():  # a coarse output that stands still scatters by nothing
            usual = [max(float(np.nanmin(usual)), LEAST * full.rest_variance[channel])]
        else:
            usual = [_white(readings), full.rest_variance[channel]]
        variance[channel] = max(float(np.nanmin(usual)), full.steps[channel] ** 2 / 12.0)
        if rows == MIN_ROWS:  # of a slow logger: so few windows of so few rows know it worse
            variance[channel] = max(variance[channel], full.rest_variance[channel])
    return variance


def _vibration(full: FullRate) -> np.ndarray:
    """(n, 6) by how much more neighbouring readings scatter in each segment than at rest.

    Nothing that a model of the motion could predict; read off high differences, in which neither
    the motion nor the reference has a part.
    """
    still = np.array([segment.kind == "static" for segment in full.segments] + [False])
    scatter = np.full((len(still), full.readings.shape[1]), np.nan)
    for k in np.unique(full.segment):
        rows = full.readings[full.segment == k]
        scatter[k] = [_white(column) for column in rows.T]
    if not np.isfinite(scatter[still]).any():
        return np.ones(full.readings.shape)
    known = np.where(np.isfinite(scatter[still]), scatter[still], np.inf)
    ratio = scatter / np.median(known, axis=0)
    return np.asarray(np.where(ratio > VIBRATING, ratio, 1.0)[full.segment])


def _usual_variance(windows: np.ndarray) -> float:
    """The median over windows (w, rows); NaN where there are too few."""
    known = windows[np.isfinite(windows).all(axis=1)]
    if len(known) < MIN_WINDOWS:
        return np.nan
    variance = float(np.median(known.var(axis=1, ddof=1)))
    return variance if variance > 0.0 else np.nan


def _white(readings: np.ndarray) -> float:
    variance = noise_by_differences(readings[np.isfinite(readings)], ORDER, 0.5) ** 2
    return variance if variance > 0.0 else np.nan


def remainder(full: FullRate, found: np.ndarray, left: LeftOver) -> Finding | None:
    """The residual above the noise as one finding; None if it may be the reference's errors.

    found: (n, 6) predicted readings. It removes nothing and adds nothing to the readings.
    """
    clear = left.beyond_reference(REFERENCE_KNOWN) >= NEAR_NOISE
    channels = tuple(np.flatnonzero(clear).tolist())
    if not channels:
        return None
    low, high = band_of(full, found, left, channels)
    return Finding(
        effect=UNNAMED,
        family=UNNAMED,
        title=message("explain-remainder", share=percent(1.0 - left.explained_share),
                      low=plain(low, 2), high=plain(high, 2)),
        equation="",
        source="",
        channels=channels,
        parameters=(),
        contribution=np.zeros_like(found),
        gain=0.0,
        delta_bic=0.0,
        held_out_gain=0.0,
        remainder=True,
    )  # fmt: skip


def band_of(
    full: FullRate, found: np.ndarray, left: LeftOver, channels: tuple[int, ...]
) -> tuple[float, float]:
    """The frequencies (Hz) between which four fifths of the power above noise lie."""
    residual = np.where(left.masked, np.nan, full.readings - found) / np.sqrt(
        left.noise * left.rows
    )
    means = block_means_at_rows(residual, left.rows)[:: left.rows, list(channels)]
    interval = full.motion.interval * left.rows
    frequency, power = welch(
        np.nan_to_num(means), 1.0 / interval, nperseg=min(len(means), round(SPECTRUM / interval)),
        axis=0,
    )  # fmt: skip
    noise = 2.0 * interval / left.rows
    above = np.maximum.accumulate(np.cumsum(power[1:].sum(axis=1) - noise * len(channels)))
    # Less than the noise in all, as of few large readings: quantiles lie beyond the end.
    low, high = np.minimum(np.searchsorted(above, above[-1] * np.array(BAND)), len(above) - 1)
    return float(frequency[1:][low]), float(frequency[1:][high])


# Refusals that one kind of physics alone asks for: what looks like it, and is something else.
#
# A dead band takes nothing off at rest; what it seems to take off there is what errs in the rate
# that the reference tells of a rest. Of faster rates it takes its whole threshold off.
#
# A bias that jumps is the same before and the same after. What the first few cells of a
# recording, or the last, have of their own is no jump for that: a warm-up, or a rest that is
# unlike all the motion after it, sets them apart as well, and too few cells do not tell that
# their bias is one.
#
# Any loop of a memory is a sum of plays (Prandtl and Ishlinskii), whose weights are of one sign,
# for each takes energy. Weights of both signs are a curvature or a derivative of the drive, no
# memory.
#
# Where neither encoders nor poses tell the attitude, each rest is as it was placed, and that is
# off by what it is. A law of the attitude with as many parameters as the rests leave values
# beside the standard's would make up for any errors of placing.
#
# Well below its corner a low-pass that lags by T changes its input f by −T·ḟ + b·f̈ with b
# between T²/2 (a delay) and T² (one pole), and the model has that. A mount that swings lags by
# its damping, and is off by the square of its period: by −f̈/ω₀² below its resonance, and by all
# of f above.

KNOWN_SIZE = 0.3  # by which physics that is known beforehand may differ from what is known
SIZE = Parameter("size", "size", "1", "1", (1.0 - KNOWN_SIZE, 1.0 + KNOWN_SIZE))
UNSEEN = 1e-3  # p value of coefficients that the faster rates show
FAST_THRESHOLDS = 3.0  # thresholds: faster than what the errors of a rest make of it
FEWEST_CELLS = 3  # cells on either side: two tell a change by themselves
MEMORY = "hysteresis"
STANDARD_AT_REST = 12  # accelerometers' matrix and bias
RESTING = np.radians(0.1)  # rad/s
OF_ACCELEROMETERS = ("accel_time_constant", "accel_lag")
CLEAR_LAG = 3.0  # standard uncertainties
MORE_CURVED = 2.0  # times the square of the lag: more than any order of filter differs by


@dataclass(frozen=True)
class Examined:
    """A finding by its number in some evidence, with the values and the standard uncertainties
    (k,) of its own columns.
    """

    evidence: Evidence
    number: int
    values: np.ndarray
    u: np.ndarray

    @property
    def group(self) -> FindingGroup:
        return self.evidence.groups[self.number]

    @cached_property
    def parameters(self) -> list[Parameter]:
        """Of each own column; known physics has a size, which is one."""
        return [parameter or SIZE for parameter in self.evidence.parameters(self.number)]

    def refused(self, kind: RefusalKind, k: int, value: float, limit: float) -> Refusal:
        """For the value of its parameter k."""
        parameter = self.parameters[k]
        name, unit = parameter.name, parameter.si
        return Refusal(kind, self.group.name, name, unit, value, limit)


def unseen_turning(one: Examined) -> Refusal | None:
    """Where a dead band's coefficients may be nothing by the faster rates alone."""
    evidence, fit, group = one.evidence, one.evidence.fit, one.group
    bands = [term for term in group.terms if THRESHOLD in term.shapes]
    if not bands:
        return None
    threshold = max(band.at[band.shapes.index(THRESHOLD)] for band in bands)
    blocks, model = fit.blocks, fit.model
    columns, prediction = fitted_columns(model, evidence.groups, blocks.motion)
    misfit = blocks.readings - prediction
    reported = np.nan_to_num(blocks.motion.rate)
    felt = reported + np.nan_to_num(misfit[:, :3])  # of a rest whose reference errs: nothing
    fast = np.minimum(np.abs(reported), np.abs(felt)) > FAST_THRESHOLDS * threshold
    turning = replace(blocks, weight=blocks.weight * np.hstack([fast, np.ones_like(fast)]))
    normal, right, _ = equations_of(columns, misfit, turning, fit.noises).normal()
    right = right + normal @ evidence.values
    covariance = inverse(normal + np.diag(evidence.prior))
    free = np.flatnonzero(model.free)
    places = [p for band in bands for p in range(*model.places[band.key].indices(len(model.free)))]
    own = np.flatnonzero(np.isin(free, places))
    values = (covariance @ right)[own]
    covariance = covariance[np.ix_(own, own)] * evidence.dispersion(one.number)
    if chi2.sf(values @ inverse(covariance) @ values, len(own)) < UNSEEN:
        return None
    u = np.sqrt(np.diag(covariance))
    k = int((np.abs(values) / u).argmax())
    parameter = parameters_of(model.terms)[free[own[k]]]
    return Refusal(
        "undetermined", group.name, parameter.name, parameter.si,
        float(values[k]), COVERAGE * float(u[k]),
    )  # fmt: skip


def jump_at_one_end(one: Examined) -> Refusal | None:
    """The jump that has too few cells before or after it to show that the bias is constant
    there.
    """
    group, blocks = one.group, one.evidence.fit.blocks
    times = [term.at[0] for term in group.terms if term.time_course == "jump"]
    if not times:
        return None
    cells, used = scatter_cells(blocks), (blocks.weight > 0).any(axis=1)
    before, after = (
        len(np.unique(cells[used & side]))
        for side in (blocks.t < min(times), blocks.t > max(times))
    )
    if min(before, after) >= FEWEST_CELLS:
        return None
    return Refusal("one_end", group.name, value=float(min(before, after)))


def loops_both_ways(one: Examined) -> Refusal | None:
    """A memory whose widths have weights of both signs, each larger than its U, in one channel."""
    if one.group.name != MEMORY:
        return None
    clear = np.where(np.abs(one.values) > COVERAGE * one.u, np.sign(one.values), 0.0)
    signs: dict[tuple[str, str], set[float]] = {}
    for parameter, sign in zip(one.parameters, clear.tolist(), strict=True):
        channel = parameter.unit, parameter.name.rsplit("_", 1)[-1]
        signs.setdefault(channel, set()).add(sign)
    both = any({1.0, -1.0} <= found for found in signs.values())
    return Refusal("both_ways", MEMORY) if both else None


def made_by_placing(one: Examined) -> Refusal | None:
    """Where a finding that turns the body has no fewer parameters than the rests leave values."""
    group, motion = one.group, one.evidence.fit.blocks.motion
    if motion.axes is not None or motion.tracking is not None:
        return None
    if not any(term.stage == "motion" for term in group.terms):
        return None
    placed = _placements(one.evidence)
    if 3 * placed - STANDARD_AT_REST > len(one.evidence.own[one.number]):
        return None
    return Refusal("placed", group.name, value=float(placed))


def _placements(evidence: Evidence) -> int:
    """Rests that were each positioned separately."""
    blocks = evidence.fit.blocks
    rests = np.linalg.norm(np.nan_to_num(blocks.motion.rate, nan=np.inf), axis=1) < RESTING
    return len(np.unique(blocks.segment[rests & (blocks.segment >= 0)]))


def swings(one: Examined) -> Refusal | None:
    """A low-pass of the accelerometers alone whose amplitude is not that of a filter."""
    lags = [
        value
        for parameter, value, u in zip(
            one.parameters, one.values.tolist(), one.u.tolist(), strict=True
        )
        if parameter.name in OF_ACCELEROMETERS or abs(value) > CLEAR_LAG * u
    ]
    alone = [parameter.name in OF_ACCELEROMETERS for parameter in one.parameters]
    if one.group.name != BANDWIDTH.name or not any(alone) or len(lags) > sum(alone):
        return None
    curvature, own = _curvature(one.evidence)
    if abs(curvature) < max(CLEAR_LAG * own, MORE_CURVED * max(lags) ** 2):
        return None
    return Refusal("swings", one.group.name)


def _curvature(evidence: Evidence) -> tuple[float, float]:
    """Coefficient c of the second derivative of the specific force in the accelerometers beside
    everything else, and its standard uncertainty; s².
    """
    fit = evidence.fit
    model, blocks = fit.model, fit.blocks
    design = model.linearised(blocks.motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free)]
    second = _second_derivative(blocks.motion)
    columns.append({channel: second[:, channel - ACCELS[0]] for channel in ACCELS})
    misfit = blocks.readings - design.prediction
    normal, right, chi2 = equations_of(columns, misfit, blocks, fit.noises).normal()
    covariance = inverse(normal)
    dispersion = max(1.0, chi2 / evidence.used)
    return float((covariance @ right)[-1]), float(np.sqrt(dispersion * covariance[-1, -1]))


def _second_derivative(motion: Motion) -> np.ndarray:
    """(n, 3) of the specific force, m/s⁴; zero where it is not known."""
    force = Inputs.of(motion).force
    slope = np.gradient(force, motion.t, axis=0)
    return np.nan_to_num(np.gradient(slope, motion.t, axis=0))
