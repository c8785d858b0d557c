"""Scatter of the unit's readings at rest: vibration, and rests that differ more than they may."""

from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np

from schemas.calibration import Item
from schemas.recording import ANGLE, AXES, Axis, Recording
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.readings.plausibility import coarse_where_it_moves, standing
from tasks.readings.robust import TO_SIGMA, median
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import (
    CHANNELS,
    LONGEST_BURST,
    SegmentMean,
    coarsely_quantised,
)
from tasks.specifications.course import comparable
from tasks.specifications.evidence import ClauseEvidence
from tasks.words.numbers import plain

# Standard deviation of the rows of a rest: noise of no unit that is worth a calibration.
MOST_DEVIATION = np.array([np.radians(1.0)] * len(AXES) + [0.5] * len(AXES))  # rad/s, m/s²
ABOVE_OTHERS = 5.0  # times that of the run's usual rest
QUIET_STEPS = 2.0  # of the output: what rounding makes of a quiet rest
BEYOND = 3.0  # times U of the zero and what the rest's own noise may do to it
# No unit is calibrated whose zero wanders so far within a run: rad/s, m/s².
LARGEST_DRIFT = (*[float(np.radians(0.1))] * len(AXES), *[0.05] * len(AXES))
ZEROS = (("gyro_bias", 0), ("ahrs_zero_offset", 0), ("accel_bias", 3))  # item, first channel
PER_SI = {"deg/s": float(np.degrees(1.0)), "m/s2": 1.0}


def scatter_remarks(evidence: ClauseEvidence, items: Mapping[str, Item]) -> Iterator[Remark]:
    """Channels whose rests disagree with one another by more than U covers, or a steady unit."""
    yield from _beyond_uncertainty(evidence, items)
    for channel, largest in enumerate(LARGEST_DRIFT):
        rests = comparable(evidence, _rests(evidence, None), channel)
        alike = channel < len(AXES) and "ahrs_zero_offset" in items  # no model of g-sensitivity
        faces = np.ones((len(rests), 1)) if alike else _faces(evidence, rests)
        drift = _drift(evidence, rests, faces, channel, largest)
        if drift is not None:
            segment, left = drift
            yield run_remark(
                "unsteady_zero", segment, run="invalid", channel=CHANNELS[channel],
                segment=segment, left=f"{left:+.2g}", limit=f"{largest:.2g}",
            )  # fmt: skip


def _beyond_uncertainty(evidence: ClauseEvidence, items: Mapping[str, Item]) -> Iterator[Remark]:
    """By the uncertainty that is stated for each zero."""
    for name, first in ZEROS:
        for number, axis in enumerate(AXES if name in items else ()):
            item, U = items[name], items[name].U.get(axis)
            rests = _rests(evidence, axis if name == "ahrs_zero_offset" else None)
            rests = comparable(evidence, rests, first + number)
            per_si = PER_SI[item.unit]
            faces = _faces(evidence, rests)
            drift = U and _drift(evidence, rests, faces, first + number, BEYOND * U / per_si)
            if drift:
                segment, left = drift
                yield run_remark(
                    "drift", segment, run="invalid", channel=CHANNELS[first + number],
                    segment=segment, left=f"{per_si * left:+.2g}", U=f"{U:.2g}", unit=item.unit,
                )  # fmt: skip


def _rests(evidence: ClauseEvidence, axis: Axis | None) -> list[int]:
    """The rests with a known axis up; of an AHRS those in which its zero about an axis is held."""
    rests = [i for i in evidence.of_kind("static") if evidence.up[i] is not None]
    return [i for i in rests if axis is None or evidence.labels[i].axis == axis]


def _drift(
    evidence: ClauseEvidence, rests: list[int], faces: np.ndarray, channel: int, allowed: float
) -> tuple[str, float] | None:
    """The rest that is farthest off, and by how much (SI); None: within `allowed` and its noise.

    Each is compared with a fit of all: a reading for each column of `faces` (rests, k), and the
    level part of Earth's rotation; if north is unknown, that much more is allowed.
    """
    means = evidence.means[rests, channel]
    if len(rests) <= faces.shape[1] or not np.isfinite(means).all():
        return None
    variance = evidence.noise.white[rests, channel] / evidence.noise.seconds[rests]
    variance += evidence.rounding_covariance(channel).diagonal()[rests]
    if evidence.accumulates:  # the two readings of an angle that make a short rest's mean rate
        variance = evidence.fast_covariance(channel).diagonal()[rests]
    noise = 2.0 * np.sqrt(variance)
    if channel < len(AXES):
        north = evidence.north[rests]
        known = bool(np.isfinite(north).all())
        level = _level(north, evidence, rests)[:, channel] if known else ()
        faces = np.column_stack([faces, *level])
        noise = noise + (0.0 if known else EARTH_RATE)
    left = means - faces @ np.linalg.lstsq(faces, means, rcond=None)[0]
    reach = allowed + BEYOND * noise
    worst = int((np.abs(left) / reach).argmax())
    if abs(left[worst]) <= reach[worst]:
        return None
    return evidence.labels[rests[worst]].name, float(left[worst])


def _faces(evidence: ClauseEvidence, rests: list[int]) -> np.ndarray:
    """(rests, faces): 1 where a rest has that axis up."""
    ups = sorted({str(evidence.up[i]) for i in rests})
    return np.array([[evidence.up[i] == up for up in ups] for i in rests], float).reshape(
        len(rests), len(ups)
    )


def _level(north: np.ndarray, evidence: ClauseEvidence, rests: list[int]) -> np.ndarray:
    """North and east (2, 3, rests) in the body."""
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    return np.stack([north.T, np.cross(north, up).T])


def vibration_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests that scatter more than any unit's noise, or much more than the others."""
    rests = [evidence.segments[i] for i in evidence.of_kind("static")]
    if not rests:
        return
    deviation = np.array([rest.deviation for rest in rests])
    usual = np.median(deviation, axis=0)
    step = np.max([rest.step for rest in rests], axis=0)
    limit = np.minimum(MOST_DEVIATION, np.maximum(ABOVE_OTHERS * usual, QUIET_STEPS * step))
    above = deviation > limit
    for channel in np.flatnonzero(above.any(axis=0)).tolist():
        shaken = [rests[i].segment.name for i in np.flatnonzero(above[:, channel])]
        yield run_remark(
            "vibration", *shaken, run="invalid", channel=CHANNELS[channel], count=len(shaken),
            first=shaken[0], deviation=f"{deviation[:, channel].max():.3g}",
            limit=f"{limit[channel]:.3g}",
        )  # fmt: skip


# Samples that are not readings of the unit: outliers and channels that stand still.

Channels = tuple[str, ...]

OFF = 4.0  # robust standard deviations: 6 normal samples of 100,000 lie beyond
LARGEST_SHARE = 0.005  # of a channel's samples that may be off
# The first look: rows of all segments together, with a nearer reach and a smaller share.
GLANCE_ROWS, GLANCE_OFF, GLANCE_SHARE = 10_000, 3.5, 0.002
FEWEST_OFF = 3  # samples off: one or two of a short run lie there by chance
HALF = 0.5  # of an output step, by which rounding may lower a median deviation


def outlier_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """What is wrong with single samples, segment by segment and in the whole run."""
    channels = evidence.channel_names
    coarse = coarse_where_it_moves(evidence.recording, evidence.labels)
    for segment in evidence.segments:
        yield from _corrupted(segment, channels)
        if not evidence.may_stand_still:
            yield from _stuck(evidence.recording, segment, channels, coarse)
    yield from _coarse(evidence.segments, channels)
    if not evidence.may_stand_still:  # rounding is no outlier
        yield from _off(evidence)


def _off(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Channels of which too many samples lie off the rest of their segment.

    An accumulated angle wanders with the rate's own error: its second differences are judged.
    """
    held = [s for s in evidence.segments if s.segment.kind != "rotation"]
    if not held:
        return
    few = _few_at_a_glance(evidence.recording, held)
    for channel, name in enumerate(CHANNELS):
        values = evidence.recording.imu.columns.get(name)
        accumulated = evidence.channel_names[channel] in ANGLE
        if values is None or (few[channel] and not accumulated):
            continue
        shares = [_share_off(evidence.recording, values, s, channel, accumulated) for s in held]
        share = float(np.average(shares, weights=[s.rows for s in held]))
        if share > LARGEST_SHARE and share * sum(s.rows for s in held) >= FEWEST_OFF:
            yield run_remark(
                "samples_off", run="invalid", channel=evidence.channel_names[channel],
                share=plain(100 * share, 2), off=f"{OFF:g}", limit=f"{100 * LARGEST_SHARE:g}",
            )  # fmt: skip


def _few_at_a_glance(recording: Recording, held: list[SegmentMean]) -> np.ndarray:
    """Channels (6,) of which rows drawn from each segment already show that few enough are off.

    Drawn at random, so that what comes back every so many rows is not missed; of a channel with
    LARGEST_SHARE off fifty are drawn, where twenty let it through.
    """
    count = GLANCE_ROWS // len(held)
    drawn = []
    for segment in held:
        rows = _drawn(segment.rows, count)
        views = recording.imu.views(CHANNELS, segment.place)
        drawn.append([values[rows] for values in views])
    here = np.array(drawn)  # (segments, 6, count)
    away = np.abs(here - median(here)[..., None])
    step = np.array([segment.step for segment in held])
    reach = GLANCE_OFF * TO_SIGMA * (median(away) + HALF * step)
    weights = np.array([segment.rows for segment in held])
    off = weights @ (away > reach[..., None]).mean(axis=2)
    return np.asarray(off <= GLANCE_SHARE * weights.sum())


@cache
def _drawn(rows: int, count: int) -> np.ndarray:
    """`count` rows drawn of so many, the same ones each time; all in turn where there are fewer."""
    if rows <= count:
        return np.resize(np.arange(rows), count)
    return np.sort(np.random.default_rng(rows).integers(0, rows, count))


def _share_off(
    recording: Recording, values: np.ndarray, segment: SegmentMean, channel: int, accumulated: bool
) -> float:
    here = values[segment.place]
    away = np.abs(np.diff(here, 2) if accumulated else here - median(here))
    reach = OFF * TO_SIGMA * (float(median(away)) + HALF * float(segment.step[channel]))
    return float((away > reach).mean())


def _corrupted(segment: SegmentMean, channels: Channels) -> Iterator[Remark]:
    """Rows that were left out of the mean."""
    if segment.left_out == 0:
        return
    name, burst = segment.segment.name, segment.longest_burst
    counts = [f"{channels[c]} {rows}" for c, rows in enumerate(segment.far_rows) if rows]
    disturbed = burst > LONGEST_BURST
    yield run_remark(
        "disturbed" if disturbed else "corrupted_rows", name,
        run="remarks" if disturbed else "valid", segment=name, out=segment.left_out,
        rows=segment.rows, channels=", ".join(counts), burst=burst,
    )  # fmt: skip


def _stuck(
    recording: Recording, segment: SegmentMean, channels: Channels, coarse: np.ndarray
) -> Iterator[Remark]:
    """A channel that stood still where noise should have moved it.

    coarse: (6,) channels whose step is wider than their noise: they may, and are found on sight.
    """
    name = segment.segment.name
    for channel, start, length in standing(recording, segment.segment):
        if not coarse[channel]:
            yield run_remark(
                "stuck", name, run="invalid", segment=name, channel=channels[channel],
                value=f"{recording.imu.columns[CHANNELS[channel]][start]:.6g}", rows=length,
                time=f"{recording.imu.t[start]:.2f}",
            )  # fmt: skip


def _coarse(segments: tuple[SegmentMean, ...], channels: Channels) -> Iterator[Remark]:
    """Channels whose step hides their noise: their means may be off by half a step."""
    flags = np.array([coarsely_quantised(segment) for segment in segments]).reshape(-1, 6)
    steps = {
        c: max(s.step[c] for s in segments) for c in np.flatnonzero(flags.any(axis=0)).tolist()
    }
    if steps:
        listed = ", ".join(f"{channels[channel]} {step:.3g}" for channel, step in steps.items())
        names = (s.segment.name for s, row in zip(segments, flags, strict=True) if row.any())
        yield run_remark("coarse_step", *names, steps=listed)
