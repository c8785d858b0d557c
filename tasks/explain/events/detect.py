"""Detects events: those that would disturb the regression before it, weaker ones after it.

Spikes: single outlying readings without a name in the catalogue.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter1d
from scipy.stats import norm

from schemas.discrepancy import FoundParameter
from schemas.recording import AXES
from tasks.explain.events.bursts import find_bursts, find_settling
from tasks.explain.events.codes import (
    CodeFault,
    cut_off,
    find_quantisation,
    find_repeats,
    noise_estimates,
)
from tasks.explain.events.event import (
    TRIAD_NAMES,
    AddedSignal,
    Event,
    Events,
    Residual,
    channel_names,
    noise_by_rate,
    without_dead,
)
from tasks.explain.events.lines import find_dominant_lines, find_lines
from tasks.explain.events.rest import BiasAtRest, find_bias_at_rest, find_dead_zone
from tasks.explain.events.saturation import find_saturation
from tasks.explain.events.stamps import (
    aligned_prediction,
    find_jitter,
    find_lost_samples,
    gap_remarks,
)
from tasks.explain.explanation import CERTAIN, CHANNELS, TRIADS
from tasks.model.fit import plain_prediction
from tasks.model.term import EVENTS
from tasks.motion.whole import STANDARD_GRAVITY, Motion
from tasks.readings.axes import TriadMatrix, fitting, triad_matrix
from tasks.readings.lattice import Quantiser, quantiser_of
from tasks.readings.plausibility import REMOVED
from tasks.words import Message, message

MIN_SPIKES = 3
THRESHOLD = 7.0  # times the noise, by which a reading stands out from both its neighbours
CORNER = 10  # rows
STEADY = 0.02  # rad/s: how far the rate may move where it counts as steady
MIN_REST = 0.05  # share of the rows at rest, so that spikes may be missing there


def events_in_readings(readings: np.ndarray, motion: Motion, start: float = 0.0) -> Events:
    """Events that disturb a regression: rows repeated or lost, limits, dead zone, steps, spikes.

    readings: (n, 6) rad/s and m/s² at the unit's full sample rate, NaN where a triad was not
    recorded. motion: at the same rows, NaN where it is not known. start: of t = 0 on the
    recording's own clock, s.
    """
    t, flat = motion.t, constant_channels(readings)
    at_ends, settling = find_settling(readings, motion)
    if at_ends.any():
        readings = np.where(at_ends, plain_prediction(readings, motion, at_ends), readings)
    quantisers = [quantiser_of(column) for column in readings.T]
    zone, zeroed = _zone(readings, motion, quantisers)
    if isinstance(zone, BiasAtRest):  # all other events act before it
        readings = readings - zone.applied(t, np.zeros(readings.shape))
    repeats = find_repeats(readings, motion, quantisers)
    limits, masked = find_saturation(readings, motion, quantisers)
    masked |= zeroed | flat | at_ends
    predicted = plain_prediction(readings, motion, masked)
    used = np.where(masked, np.nan, readings)
    if masked.any():
        quantisers = [quantiser_of(column) for column in used.T]
    held = masked if repeats is None else masked | repeats.held
    jitter = find_jitter(readings, motion, predicted, held)
    lost = find_lost_samples(readings, motion, masked, start)
    if lost is not None:
        masked = masked | (lost.sampled_at(t) > t[-1])[:, None]  # what moved them is not known
        predicted, _ = aligned_prediction(lost.sampled_at(t), readings, motion, masked)
    times = (event for event in (jitter, repeats, lost) if event is not None)
    events: tuple[Event, ...] = (*times, *limits)
    residual = readings - predicted
    if events:
        corrected = Events(events, masked).corrected(t, readings, predicted)
        residual = corrected - plain_prediction(corrected, motion, masked)
    noises = noise_estimates(used, readings - residual, quantisers)
    short = cut_off(
        noises, used, lambda c: np.asarray((motion.rate if c < 3 else motion.force)[:, c % 3])
    )
    steps = find_quantisation(noises, short)
    level = without_dead(noise_by_rate(used - predicted, motion))
    if steps is not None:
        level = steps.noise_floor(level)
    spikes, at_spikes = find_spikes(used, np.where(masked, np.nan, residual), level, motion)
    lines: tuple[AddedSignal, ...] = ()
    if motion.tracking is None:  # poses do not show how a body vibrates
        unmasked = np.where(masked | at_spikes, np.nan, residual)
        lines = find_dominant_lines(Residual.of(t, unmasked, level, motion), predicted)
    # In the order in which they act: what is added, when a reading was taken, limit, rounding,
    # threshold.
    last = tuple(event for event in (steps, zone, spikes) if event is not None)
    remarks = (*settling, *gap_remarks(t), *flat_remarks(flat), *cut_off_remarks(short))
    return Events((*lines, *events, *last), masked | at_spikes, remarks)


def constant_channels(readings: np.ndarray) -> np.ndarray:
    """(6,) bool: channels that read one value throughout.

    What has no noise would determine every model exactly: such a channel is not used.
    """
    known = np.isfinite(readings)
    top = np.where(known, readings, -np.inf).max(axis=0)
    bottom = np.where(known, readings, np.inf).min(axis=0)
    return np.asarray(top == bottom)


def flat_remarks(flat: np.ndarray) -> tuple[Message, ...]:
    """Which channels are not used because they read one value throughout."""
    if not flat.any():
        return ()
    names = channel_names(tuple(np.flatnonzero(flat).tolist()))
    return (message("events-constant", channels=names),)


def cut_off_remarks(shares: Mapping[int, float]) -> tuple[Message, ...]:
    """Which channels read what share of their input with little noise."""
    return tuple(
        message("events-cut-off", channel=channel_names((channel,)), share=f"{100.0 * share:.0f}")
        for channel, share in shares.items()
    )


def _zone(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> tuple[Event | None, np.ndarray]:
    """What firmware does to small rates, and the readings (n, 6) bool that say nothing for it.

    An estimate of the bias is a closer account of rests whose means lie at zero, and masks none.
    """
    zone, zeroed = find_dead_zone(readings, motion, quantisers)
    if zone is not None and zone.thresholds:
        return zone, zeroed
    estimated = find_bias_at_rest(readings, motion)
    return (zone, zeroed) if estimated is None else (estimated, np.zeros(readings.shape, bool))


def events_in_residual(
    events: Events, residual: np.ndarray, noise: np.ndarray, motion: Motion, start: float = 0.0
) -> Events:
    """The events found before a regression, and lines and bursts in its residual.

    residual: (n, 6) readings minus `events.applied` to the prediction of the fitted model, NaN
    where that is unknown. noise: (6,) standard deviation of a sample, for channels whose residual
    does not scatter. motion: at the same rows. start: of t = 0 on the recording's own clock, s.
    These events add to what the unit senses, so they act before all others. Poses do not show how
    a body vibrates: fast components of the residual need not be errors, unless they have the mains'
    frequency throughout.
    """
    t, values = motion.t, np.where(events.masked, np.nan, residual)
    level = without_dead(noise_by_rate(values, motion))
    level = np.where(level == 0, noise, level)
    for event in events.events:
        t, level = event.sampled_at(t), event.noise_floor(level)
    left = Residual.of(t, values, level, motion)
    lines = find_lines(left)
    if motion.tracking is not None:
        mains = tuple(line for line in lines if line.effect in EVENTS)
        return Events((*mains, *events.events), events.masked, events.remarks)
    nonlinear = tuple(c for event in events.events if not event.linear for c in event.channels)
    bursts = find_bursts(left.without(*lines).without_channels(nonlinear), start)
    transients = () if bursts is None else (bursts,)
    return Events((*lines, *transients, *events.events), events.masked, events.remarks)


def find_spikes(
    readings: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Single readings far from both their neighbours, and which (n, 6) bool to mask for them.

    In the readings and in what a plain fit leaves of them (n, 6): the one has the motion's corners,
    the other those of the reference's noise.
    """
    apart = np.minimum(_apart(readings, noise), _apart(residual, noise))
    far = (apart > THRESHOLD) & _steady(motion.rate)[:, None]
    masked = np.asarray(binary_dilation(far, np.ones((3, 1))))
    # A neighbour of a spike stands out as well, by less.
    size = np.where(far, apart, 0.0)
    peak = far & (size == maximum_filter1d(size, 3, axis=0, mode="constant"))
    rows = peak.any(axis=1)
    count = int(rows.sum())
    if count < MIN_SPIKES:
        return None, masked
    channels = tuple(np.flatnonzero(peak.any(axis=0)).tolist())
    at_rest = np.linalg.norm(motion.rate, axis=1) < STEADY
    turning = bool(at_rest.mean() > MIN_REST and not (rows & at_rest).any())
    description = message(
        "events-spikes-in-rotation" if turning else "events-spikes",
        count=count, threshold=f"{THRESHOLD:.0f}", channels=channel_names(channels),
    )  # fmt: skip
    parameters = (FoundParameter(name="spikes", value=float(count), unit="1", u=0.0),)
    expected = far.size * 2 * norm.sf(THRESHOLD)
    p_value = float(min(1.0, expected**MIN_SPIKES))
    return Event("unnamed", channels, parameters, p_value, description), masked


def _apart(values: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(n, 6) times the noise by which values are off the middle of their neighbours."""
    white = np.divide(values, noise, out=np.full(values.shape, np.nan), where=noise > 0)
    apart = np.zeros(values.shape)
    apart[1:-1] = np.abs(white[1:-1] - 0.5 * (white[:-2] + white[2:])) / np.sqrt(1.5)
    return apart


def _steady(rate: np.ndarray) -> np.ndarray:
    """Rows (n,) bool about which the rate does not change: a corner of a ramp is no spike."""
    moving = np.ones(len(rate), bool)
    change = np.abs(rate[2 * CORNER :] - rate[: -2 * CORNER]).max(axis=1, initial=0.0)
    moving[CORNER:-CORNER] = ~(change < STEADY)
    return ~maximum_filter1d(moving, 2 * CORNER + 1, mode="constant")


# Faults of logger and firmware that last from the first row to the last: wrong settings and
# codes.
#
# Both are undone before anything else is looked for. Of settings, axes, range and unit of a
# triad: what it reads per unit of each input is the coarsest fact of a unit. A matrix fitted to
# means over short windows shows it before anything else is known. A delay, a motion of its own or
# a fault of the codes would bend that matrix, too; so that it must leave next to nothing of what
# is read.
#
# A working unit reads each axis along itself, to within a few degrees: a matrix that does so only
# after some axes are exchanged or inverted tells which. And its scale factors lie near one. The
# standard's scale factors absorb a wrong range, so that no residual shows it; but all of a triad
# near another number, and that one of the few that settings make, is a setting.

STILL = np.radians(0.5)  # rad/s: what turns slower rests
TIED = 0.01  # of what is read along the axes: inputs along the axis of a turn do not show it
WORKING = 0.05  # standard deviation of a working unit's scale factors about one
NEAR = 0.08  # of a usual factor: as near as working units are
OWN = 0.01  # of the factor: what scale factors of the unit's own may have in common
ALIKE = 0.03  # of the factor: how much the axes may differ
# Twice the logarithm by which a factor that is found costs more than one that is usual: it may lie
# anywhere from a tenth to ten, and three axes of working units tell it to 3 %.
OF_ANY_FACTOR = 2.0 * float(np.log(np.log(100.0) / (0.03 * np.sqrt(2.0 * np.pi))))
RANGE_SETTING = "range_setting"
POWERS_OF_TWO = tuple(2.0**n for n in range(-5, 6) if n)
# By how much each usual mistake multiplies what is read, by triad: gyros, accelerometers.
BOTH = {
    "power-of-two": POWERS_OF_TWO,
    "thousand": (1e-3, 1e3),
}
USUAL = (
    BOTH | {"degrees": (180.0 / np.pi,), "radians": (np.pi / 180.0,)},
    BOTH | {"gravities": (1.0 / STANDARD_GRAVITY,), "metric": (STANDARD_GRAVITY,)},
)


@dataclass(frozen=True)
class AxisMapping(Event):
    """triad: 0 gyros, 1 accelerometers. matrix: (3, 3) that readings are multiplied by."""

    triad: int
    matrix: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._by(predicted, self.matrix)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with each axis in its place."""
        return self._by(readings, self.matrix.T)

    def _by(self, readings: np.ndarray, matrix: np.ndarray) -> np.ndarray:
        changed = readings.copy()
        own = list(TRIADS[self.triad])
        changed[:, own] = readings[:, own] @ matrix.T
        return changed


def axis_mapping(triad: int, matrix: np.ndarray, with_mount: bool) -> AxisMapping:
    """The event of a signed permutation; with_mount: a wrongly stated mount would look the same."""
    rows = [row for row in range(3) if matrix[row, row] != 1.0]
    texts = []
    for row in rows:
        source = int(np.abs(matrix[row]).argmax())
        channel = message(f"channel-{CHANNELS[TRIADS[triad][row]]}")
        sign = "+" if matrix[row, source] > 0 else "−"
        texts.append(message("events-axis-reads", channel=channel, sign=sign, axis=AXES[source]))
    parameters = tuple(
        FoundParameter(name=f"{AXES[row]}{AXES[k]}", value=float(matrix[row, k]), unit="1", u=0.0)
        for row in rows for k in range(3) if matrix[row, k]
    )  # fmt: skip
    return AxisMapping(
        "axis_mapping", tuple(TRIADS[triad][row] for row in rows), parameters, 1e-12,
        message("events-axis-mapping", sensors=TRIAD_NAMES[triad], axes=tuple(texts)),
        triad, matrix, indistinguishable=("reference_frame",) if with_mount else (),
    )  # fmt: skip


@dataclass(frozen=True)
class RangeSetting(Event):
    """triad: 0 gyros, 1 accelerometers. factor: that all its readings are multiplied by."""

    triad: int
    factor: float

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._times(predicted, self.factor)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) as a right setting gives them."""
        return self._times(readings, 1.0 / self.factor)

    def _times(self, readings: np.ndarray, factor: float) -> np.ndarray:
        changed = readings.copy()
        changed[:, list(TRIADS[self.triad])] *= factor
        return changed


def find_range_setting(matrix: TriadMatrix, triad: int) -> RangeSetting | None:
    """The factor of a triad, where the scale factors are those of no working unit without it."""
    sizes = np.linalg.svd(matrix.reads, compute_uv=False)
    if not sizes.min() > 0.0:
        return None
    common = float(np.exp(np.log(sizes).mean()))
    spread = float(np.abs(np.log(sizes / common)).max())
    factor, cause = _usual(common, triad)
    if spread > ALIKE or abs(np.log(factor)) < NEAR:
        return None
    if cause == "counts" and len(sizes) < 2:  # of one axis it may be the unit's own
        return None
    log_odds = float(np.sum(_surprise(sizes) - _surprise(sizes / factor)))
    if cause == "counts":
        log_odds -= OF_ANY_FACTOR
    if log_odds < CERTAIN:
        return None
    u = factor * max(abs(common / factor - 1.0), OWN if cause == "counts" else 0.1 * OWN)
    return RangeSetting(
        RANGE_SETTING, TRIADS[triad],
        (FoundParameter(name="factor", value=factor, unit="1", u=float(u)),),
        float(np.exp(-0.5 * min(log_odds, 1000.0))),
        message(
            "events-range", sensors=TRIAD_NAMES[triad], factor=f"{factor:.5g}",
            cause=message(f"events-range-{cause}"),
        ), triad, factor,
        indistinguishable=("table_scale",) if triad == 0 and len(sizes) == 1 else (),
    )  # fmt: skip


def _usual(common: float, triad: int) -> tuple[float, str]:
    """The nearest usual factor, and its cause; otherwise the factor itself."""
    factors = [(factor, cause) for cause, some in USUAL[triad].items() for factor in some]
    nearest = min([*factors, (1.0, "counts")], key=lambda one: abs(np.log(common / one[0])))
    return nearest if abs(np.log(common / nearest[0])) < NEAR else (common, "counts")


def _surprise(scale_factors: np.ndarray) -> np.ndarray:
    """Chi-squared of scale factors as those of a working unit, by their logarithm."""
    return np.asarray((np.log(scale_factors) / WORKING) ** 2)


Setting = RangeSetting | AxisMapping


@dataclass(frozen=True, eq=False)
class GravityRemoved(Event):
    """force: (n, 3) m/s² of gravity's reaction, which was taken off the accelerometers' rows."""

    force: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._with(predicted, -1.0)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with gravity, NaN of accelerometers where the attitude is not known."""
        return self._with(readings, 1.0)

    def _with(self, readings: np.ndarray, sign: float) -> np.ndarray:
        changed = readings.copy()
        changed[:, list(TRIADS[1])] += sign * self.force
        return changed


Fault = Setting | CodeFault | GravityRemoved


def find_gravity_removed(readings: np.ndarray, motion: Motion) -> GravityRemoved | None:
    """Accelerometers that read next to nothing at rest, where the attitude is known."""
    force = motion.force
    still = np.linalg.norm(np.nan_to_num(motion.rate, nan=np.inf), axis=1) < STILL
    still &= np.isfinite(force).all(axis=1)
    read = (
        np.median(np.linalg.norm(readings[still][:, list(TRIADS[1])], axis=1))
        if still.any()
        else 0.0
    )
    if not 0.0 < read < REMOVED * motion.gravity:
        return None
    return GravityRemoved(
        "gravity_removed", TRIADS[1],
        (FoundParameter(name="at_rest", value=float(read), unit="m/s2", u=0.0),), 1e-12,
        message("plausibility-gravity-removed", read=f"{read:.2g}"), force,
    )  # fmt: skip


def find_settings(readings: np.ndarray, motion: Motion, tracked: bool) -> tuple[Setting, ...]:
    """Wrong settings of readings (n, 6) rad/s, m/s², in the order in which they act.

    tracked: the motion is that of a tracked body, which may be turned against the unit in any way,
    so that what turns both triads alike is the reference's.
    """
    matrices = [triad_matrix(readings, motion, triad) for triad in range(len(TRIADS))]
    known = {triad: found for triad, found in enumerate(matrices) if found is not None}
    ranges = [find_range_setting(found, triad) for triad, found in known.items()]
    return (*_mappings(known, tracked), *(found for found in ranges if found is not None))


def _mappings(matrices: dict[int, TriadMatrix], tracked: bool) -> list[AxisMapping]:
    choices = {triad: fitting(found) for triad, found in matrices.items()}
    wrong = [t for t, good in choices.items() if good and not np.array_equal(good[0], np.eye(3))]
    if not wrong:
        return []
    common = [
        matrix
        for matrix in choices[wrong[0]]
        if np.linalg.det(matrix) > 0 and all(_reads_as(one, matrix) for one in matrices.values())
    ]
    # What a turned mount, or tracked body, would do to all that is known.
    if common:
        return [] if tracked else [axis_mapping(triad, common[0], True) for triad in wrong]
    return [axis_mapping(triad, choices[triad][0], False) for triad in wrong]


def _reads_as(found: TriadMatrix, turned: np.ndarray) -> bool:
    """Whether a triad reads as one that is turned, at least as well as one that is not: a single
    attitude leaves both open where the turn is about its vertical.
    """
    along = [float(np.sum((one @ found.directions) * found.reads)) for one in (turned, np.eye(3))]
    good = fitting(replace(found, reads=turned.T @ found.reads))
    is_along = any(np.array_equal(one, np.eye(3)) for one in good)
    return is_along and along[0] > (1.0 - TIED) * along[1]
