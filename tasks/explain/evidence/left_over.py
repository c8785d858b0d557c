"""The residual after all findings, relative to the noise of sensor and reference.

The sensor's noise is read off short stretches at rest, where no model is needed, and not off what
a model leaves: a model that lacks something would call noise what it lacks. The reference's is its
own account of itself; beyond the band in which poses tell the motion nothing is held against them.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import welch

from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.blocks import VIBRATING, FullRate
from tasks.motion.samples import in_blocks, noise_by_differences
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
