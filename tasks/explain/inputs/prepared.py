"""A recording prepared for the search: faults, events and a long delay of the stamps removed."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import orth

from schemas.base import Unusable
from schemas.recording import Recording, Segment
from tasks.explain.events.codes import code_fault, find_repeats, find_torn_codes
from tasks.explain.events.detect import (
    Fault,
    events_in_readings,
    find_gravity_removed,
    find_settings,
)
from tasks.explain.events.event import Events
from tasks.explain.events.stamps import LostSamples, aligned_prediction
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.blocks import Blocks, FullRate, block_means, full_rate
from tasks.explain.inputs.reference import (
    ReferencePrediction,
    disturbed_rows,
    in_unit_axes,
    moved_labels,
)
from tasks.explain.inputs.signals import within_jumps
from tasks.explain.progress import Progress, report_progress, silent
from tasks.model.fit import plain_prediction
from tasks.model.terms.timing import shifted_within
from tasks.motion.encoders import as_mean_rates
from tasks.motion.samples import SLOW, bridged, interpolated
from tasks.motion.whole import Motion, attitude_stream, whole_motion
from tasks.readings.codes import codes_put_right, offset_taken_off
from tasks.readings.lattice import quantiser_of
from tasks.readings.plausibility import longest_run, on_sight, shift_of_labels
from tasks.readings.rows import (
    empty_remarks,
    rows_without_readings,
    without_readings_removed,
)
from tasks.readings.stamps import with_instants
from tasks.segments.find import segments_of
from tasks.words import Sayable, say

LONG = 1600.0  # s: blocks of a longer run are as much longer, so that it costs no more
THINNED = 0.1  # of the rows, at least, that lack a triad, and that have both
SCATTERED = 100  # rows without it in one stretch: more, and it was not recorded there
ROUNDS = 4  # of a fit whose prediction shows what events did to the readings


@dataclass(frozen=True)
class Prepared:
    """A recording without faults of its logger, as it is, and without its events and delay.

    recorded: with rates in place of angles, without empty rows. faults: of its logger, undone in
    all that follows. recording, full: without them, at the unit's rows. clean: without events, and
    with the stamps `delay` s earlier, by which they were late. masked: (n, 6) bool, readings that
    say nothing. reference: the prediction by which the readings of `clean` were reduced to those of
    an ideal unit.
    """

    recorded: Recording
    faults: tuple[Fault, ...]
    recording: Recording
    full: FullRate
    clean: FullRate
    delay: float
    events: Events
    masked: np.ndarray
    reference: ReferencePrediction | None = None

    def blocks(self, rate: float) -> Blocks:
        """Block means at a rate, Hz; of a long run at a lower one. Lines that were removed are not
        compared: what the reference has at their frequencies is as unknown as their source.
        """
        return self._blocks_of(self.clean, rate)

    def blocks_as_stamped(self, rate: float) -> Blocks:
        """The same with the stamps as they were recorded."""
        return self._blocks_of(replace(self.clean, motion=self.full.motion), rate, self.delay)

    def blocks_of_other(self, rows: FullRate, rate: float) -> Blocks:
        """At the very rate of other blocks, of other readings or another motion at the unit's rows:
        where the recording's own say something.
        """
        return block_means(rows, rate, self.events.masked, fewest=1)

    def _blocks_of(self, rows: FullRate, rate: float, delay: float = 0.0) -> Blocks:
        share = min(1.0, LONG / float(self.full.motion.t[-1]))
        blocks = block_means(rows, share * rate, self.masked)
        weight = np.where(known_before(blocks.motion, delay), blocks.weight, 0.0)
        return replace(blocks, weight=weight, lines=self.events.lines)


def known_before(motion: Motion, late: float) -> np.ndarray:
    """(n, 6) bool: what each axis felt is known, and what it felt about `late` s before as well.

    Beside a gap of encoders or poses a late reading has no prediction; there a fit that has found a
    delay would compare nothing with something.
    """
    felt = motion.felt
    if felt.all() or (motion.axes is None and motion.tracking is None):
        return felt
    if not late and motion.interval >= SLOW:
        return felt  # only steady motion is known of so slow a recording, whatever the delay
    earlier = shifted_within(motion, np.where(felt, 0.0, np.nan), late + 0.5 * motion.interval)
    return np.asarray(felt & np.isfinite(earlier))


def prepare(
    recording: Recording,
    reference: ReferencePrediction | None = None,
    *,
    delay_sought: bool = True,
    progress: Progress = silent,
) -> Prepared:
    """The inputs of a search. Lost samples hide a delay until they are known, so that it is sought
    before and after them, and held ones feign one.

    Raises Unusable where the recording tells no motion or is too short.
    """
    report_progress(progress, "motion")
    recorded = _rows_of_both(as_mean_rates(with_instants(offset_taken_off(recording))))
    right = codes_put_right(recorded)
    empty = rows_without_readings(right)
    recorded, right = (without_readings_removed(one, empty) for one in (recorded, right))
    sight = on_sight(right, segments_of(right))
    if any(one.code == "time_unit" for one in sight):
        name = recording.manifest.recording_id
        first = next(one for one in sight if one.code == "time_unit")
        raise Unusable(f"recording {name}: {say(first)}")
    if any(one.code == "labels_shifted" for one in sight):
        shift = shift_of_labels(right)
        if shift is not None:
            recorded, right = (moved_labels(one, shift) for one in (recorded, right))
    faults, right, full = without_faults(recorded, right, reference)
    late = coarse_delay(_between_fresh(full)) if delay_sought else 0.0
    on_time = full_rate(advanced(right, late)) if late else full
    pose, on_turn = in_unit_axes(right, on_time.motion)
    if pose is not None:
        recorded, right = (replace(one, reference=pose) for one in (recorded, right))
        full = full_rate(right)
    on_reading: tuple[Sayable, ...] = (
        *right.put_right,
        *sight,
        *empty_remarks(recorded.imu.t, empty),
    )
    full = replace(full, remarks=(*on_reading, *full.remarks, *on_turn))
    report_progress(progress, "events")
    delay = late if pose is None or not delay_sought else coarse_delay(_between_fresh(full))
    rows, events = _with_delay(right, full, delay)
    losses = [event for event in events.events if isinstance(event, LostSamples)]
    more = coarse_delay(rows, until=losses[0].times[0]) if losses and delay_sought else 0.0
    if more:
        delay += more
        rows, events = _with_delay(right, full, delay)
    clean, masked = _without_events(rows, events)
    if reference is not None:
        clean = replace(clean, readings=clean.readings - reference.beyond_ideal(full.motion))
    as_stamped = _as_stamped(full, clean.motion, delay)
    return Prepared(recorded, faults, right, as_stamped, clean, delay, events, masked, reference)


def _rows_of_both(recording: Recording) -> Recording:
    """The rows with both triads, where one is read so much less often than the other: what depends
    on neighbouring rows has none otherwise.
    """
    lost = [np.isnan(recording.imu.columns[c]) for c in CHANNELS if c in recording.imu.columns]
    read = ~np.any(lost, axis=0) if lost else np.ones(len(recording.imu), bool)
    is_thin = THINNED < read.mean() < 1.0 - THINNED and longest_run(~read) < SCATTERED
    return replace(recording, imu=recording.imu.at(read)) if is_thin else recording


def without_faults(
    recorded: Recording, right: Recording, reference: ReferencePrediction | None = None
) -> tuple[tuple[Fault, ...], Recording, FullRate]:
    """Faults of the logger, and the recording without them, as it is and at the unit's rate.

    right: the recording with its codes put right.
    """
    codes = code_fault(recorded, right)
    right = _without_undecided(right)
    full = full_rate(right)
    if codes is None and (codes := find_torn_codes(full.readings, full.motion)) is not None:
        right = _undone(right, codes)
        full = full_rate(right)
    tracked = recorded.table is None and recorded.reference is not None
    removed = None if reference or tracked else find_gravity_removed(full.readings, full.motion)
    if removed is not None:
        right = _undone(right, removed)
        full = full_rate(right)
    settings = () if reference else find_settings(full.readings, full.motion, tracked)
    for setting in reversed(settings):
        right = _undone(right, setting)
    faults = (*settings, *(fault for fault in (removed, codes) if fault is not None))
    return faults, right, full_rate(right) if settings else full


def _undone(recording: Recording, fault: Fault) -> Recording:
    readings = fault.undone(recording.imu.stack(CHANNELS))
    own = {c: readings[:, k] for k, c in enumerate(CHANNELS) if c in recording.imu.columns}
    imu = replace(recording.imu, columns={**recording.imu.columns, **own})
    return replace(recording, imu=imu)


def _without_undecided(recording: Recording) -> Recording:
    """The recording with NaN where codes could not be put right."""
    columns = dict(recording.imu.columns)
    for one in recording.wrong_codes:
        columns[one.channel] = np.where(one.undecided, np.nan, columns[one.channel])
    return replace(recording, imu=replace(recording.imu, columns=columns))


def _as_stamped(full: FullRate, earlier: Motion, delay: float) -> FullRate:
    """What was recorded, with the acceleration that gyros showed `delay` s later."""
    if full.motion.tracking is None or not delay:
        return full
    shown = shifted_within(earlier, earlier.acceleration, -delay)
    own = full.motion.acceleration
    acceleration = np.where(np.isfinite(shown) & np.isfinite(own), shown, own)
    return replace(full, motion=replace(full.motion, acceleration=acceleration))


def _between_fresh(full: FullRate) -> FullRate:
    """The readings with straight lines between samples where a row holds that of another: what is
    held is late by itself, and would be taken for a delay of all stamps.
    """
    repeats = find_repeats(full.readings, full.motion, [quantiser_of(c) for c in full.readings.T])
    if repeats is None or repeats.slipped.any():
        return full
    lines = bridged(np.where(repeats.held, np.nan, full.readings))
    return replace(full, readings=np.where(repeats.held, lines, full.readings))


def _with_delay(recording: Recording, full: FullRate, delay: float) -> tuple[FullRate, Events]:
    rows = full_rate(advanced(recording, delay)) if delay else full
    events = events_in_readings(rows.readings, rows.motion, rows.start)
    unknown = within_jumps(recording, rows.motion.t + rows.start)
    disturbed, remarks = disturbed_rows(recording)
    masked = events.masked | (unknown | disturbed)[:, None]
    return rows, replace(events, masked=masked, remarks=(*events.remarks, *remarks))


def _without_events(full: FullRate, events: Events) -> tuple[FullRate, np.ndarray]:
    """The readings as they were before the events changed them, and which (n, 6) say nothing."""
    if not events.events:
        return full, events.masked
    corrected, t = full.readings, full.motion.t
    for event in events.events:
        if isinstance(event, LostSamples):
            instants = event.sampled_at(t)
            first, _ = aligned_prediction(instants, corrected, full.motion, events.masked)
            corrected = events.corrected(t, corrected, first)
    for _ in range(ROUNDS):
        predicted = plain_prediction(corrected, full.motion, events.masked, own_squared_rate=True)
        corrected = events.corrected(t, full.readings, predicted)
    masked = events.masked | (np.isnan(corrected) & np.isfinite(predicted))
    readings = np.where(np.isfinite(corrected), corrected, full.readings)
    return replace(full, readings=readings), masked


def advanced(recording: Recording, delay: float) -> Recording:
    """The recording with the unit's stamps `delay` seconds earlier."""
    return replace(recording, imu=replace(recording.imu, t=recording.imu.t - delay))


# The segments of a recording by which a report says where something sits.

TURNING = 0.1  # rad/s: what turns so much does not rest, whatever the noise of its poses


def shown_segments(recording: Recording) -> tuple[Segment, ...]:
    """The labelled segments, or those found; no rest where poses turn, as where a hand moves so
    evenly that the quietest tenth of its readings is no quieter than the rest.
    """
    segments = segments_of(recording)
    if recording.manifest.segments or attitude_stream(recording) is not recording.reference:
        return segments
    turns = np.linalg.norm(whole_motion(recording).rate, axis=1)
    return tuple(each for each in segments if not _turns(each, recording, turns))


def _turns(segment: Segment, recording: Recording, turns: np.ndarray) -> bool:
    own = turns[recording.imu.rows(segment.t_start, segment.t_end)]
    own = own[np.isfinite(own)]
    still = not len(own) or np.sqrt((own**2).mean()) < TURNING
    return segment.kind == "static" and not still


# A long delay of all stamps, found before the model is linearised without one.
#
# A motion that oscillates determines a delay by its phase only to within half a period; a fit that
# begins at nothing ends on the wrong turn. So the slow motion is compared first, by means over long
# windows, and what is faster over ever shorter ones: each determines the turn of the next.

WIDTHS = (0.32, 0.16, 0.08, 0.04)  # s: windows of mean rates, from slow to fast
MAX_DELAY = 0.3  # s
MIN_DELAY = 0.01  # s: what is shorter a fit finds by itself
LAGS = 41  # within each span
CLEAR = 2.0  # times less misfit than without a delay
MIN_WINDOWS = 30
RANK = 1e-9


def coarse_delay(full: FullRate, until: float = np.inf) -> float:
    """Seconds by which all stamps are late, to a few milliseconds; 0 where no long one is clear.

    Of poses any delay, however short: half a frame is usual, and known better than a frame.

    Integrals of the gyros beside those of the motion's rates; each gyro follows a straight line
    in the three rates, so that scale factors, cross coupling and biases do not matter.
    until: s, what is later is not used, such as stamps after samples were lost.
    """
    t = full.motion.t
    known = full.motion.felt[:, 0] & np.isfinite(full.readings[:, :3]).all(axis=1) & (t < until)
    if known.sum() < 2:
        return 0.0
    turned, read = (
        cumulative_trapezoid(np.where(known[:, None], rates, 0.0), t, axis=0, initial=0)
        for rates in (full.motion.rate, full.readings[:, :3])
    )
    gaps = np.cumsum(~known)
    delay, span = 0.0, MAX_DELAY
    # Windows shorter than the interval of a slow unit's rows show straight lines between them.
    widths = [width for width in WIDTHS if width >= full.motion.interval]
    if not widths:
        return 0.0
    for width in widths:
        edges = np.arange(t[0] + 2.0 * MAX_DELAY, t[-1] - 2.0 * MAX_DELAY, width)
        if len(edges) <= MIN_WINDOWS:
            return 0.0
        before, after = (np.interp(edges + reach, t, gaps) for reach in (-MAX_DELAY, MAX_DELAY))
        whole = after[1:] == before[:-1]  # windows without a gap within any delay
        if whole.sum() < MIN_WINDOWS:
            return 0.0
        lags = delay + np.linspace(-span, span, LAGS)
        without, *misfits = _misfits(np.append(0.0, lags), t, turned, read, edges, whole)
        best = int(np.argmin(misfits))
        delay = float(lags[best])
        span = 0.25 * width
    if full.motion.tracking is not None:
        return delay + (lags[1] - lags[0]) * _vertex(misfits, best)
    clear = MIN_DELAY <= abs(delay) <= MAX_DELAY and without > CLEAR * min(misfits)
    return delay if clear else 0.0


def _vertex(misfits: list[float], best: int) -> float:
    """Where a parabola through the least misfit and its neighbours is least, in steps from it."""
    if not 0 < best < len(misfits) - 1:
        return 0.0
    before, least, after = misfits[best - 1 : best + 2]
    bend = before - 2.0 * least + after
    return 0.5 * (before - after) / bend if bend > 0 else 0.0


def _misfits(
    lags: np.ndarray, t: np.ndarray, turned: np.ndarray, read: np.ndarray, edges: np.ndarray,
    whole: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Sums of squares that straight lines in the motion's rates leave of the gyros', read late.

    turned, read: (n, 3) angles of the motion and of the gyros at t (n,). Rates are means over the
    windows between edges (k + 1,); whole: (k,) bool, those that count.
    """
    width = edges[1] - edges[0]
    rates = (np.diff(interpolated(edges, t, turned), axis=0) / width)[whole]
    basis = orth(np.column_stack([rates, np.ones(len(rates))]), rcond=RANK)
    misfits = []
    for lag in lags:
        means = (np.diff(interpolated(edges + lag, t, read), axis=0) / width)[whole]
        misfits.append((means**2).sum() - ((basis.T @ means) ** 2).sum())
    return np.array(misfits)
