"""Samples that are not readings of the unit: outliers and channels that stand still."""

from collections.abc import Iterator
from functools import cache

import numpy as np

from schemas.recording import ANGLE, Recording
from schemas.text import Remark
from tasks.readings.robust import TO_SIGMA, median
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import (
    CHANNELS,
    LONGEST_BURST,
    SegmentMean,
    coarsely_quantised,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.words.quantities import plain

Channels = tuple[str, ...]

STUCK_SECONDS = 2.0
OFF = 4.0  # robust standard deviations: 6 normal samples of 100,000 lie beyond
LARGEST_SHARE = 0.005  # of a channel's samples that may be off
# The first look: rows of all segments together, with a nearer reach and a smaller share.
GLANCE_ROWS, GLANCE_OFF, GLANCE_SHARE = 10_000, 3.5, 0.002
FEWEST = 3  # samples off: one or two of a short run lie there by chance
HALF = 0.5  # of an output step, by which rounding may lower a median deviation
ROUNDING = 1e-6  # of a step, by which the mean of one value may be off it


def outlier_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """What is wrong with single samples, segment by segment and in the whole run."""
    channels = evidence.channel_names
    coarse = _coarse_where_it_moves(evidence)
    for segment in evidence.segments:
        yield from _corrupted(segment, channels)
        if not evidence.may_stand_still:
            yield from _stuck(evidence.recording, segment, channels, coarse)
    yield from _coarse(evidence.segments, channels)
    if not evidence.may_stand_still:  # rounding is no outlier
        yield from _off(evidence)


def _coarse_where_it_moves(evidence: ClauseEvidence) -> np.ndarray:
    """Channels (6,) whose step is larger than their noise in most segments in which they move.

    One that moves in none is coarse where it stands at different values. In a turn by an angle the
    rate itself moves it.
    """
    held = [s for s in evidence.segments if s.segment.kind != "rotation"]
    if not held:
        return np.zeros(6, bool)
    moves = np.array([s.deviation > ROUNDING * s.step for s in held])
    hidden = np.array([coarsely_quantised(s) for s in held]) & moves
    stands = [len(set(means)) > 1 for means in evidence.means.T.tolist()]
    return np.where(moves.any(axis=0), hidden.sum(axis=0) > 0.5 * moves.sum(axis=0), stands)


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
        if share > LARGEST_SHARE and share * sum(s.rows for s in held) >= FEWEST:
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

    coarse: (6,) channels whose step is larger than their noise in most segments: they may.
    """
    if segment.segment.kind == "rotation":
        return
    interval = segment.seconds / segment.rows
    shortest = min(max(20, round(STUCK_SECONDS / interval)), segment.rows)
    name = segment.segment.name
    views = recording.imu.views(CHANNELS, segment.place)
    # A run of `shortest` rows holds two neighbours of a sample that takes every half of it.
    sample = np.array([values[:: max(1, shortest // 2)] for values in views])
    repeats = (sample[:, 1:] == sample[:, :-1]).any(axis=1) | (sample.shape[1] == 1)
    for channel in np.flatnonzero(repeats & np.isfinite(segment.mean)).tolist():
        values = views[channel]
        start, length = _longest_repeat(values)
        if length < shortest:
            continue
        yield run_remark(
            "stuck", name, run="remarks" if coarse[channel] else "invalid",
            segment=name, channel=channels[channel],
            value=f"{values[start]:.6g}", rows=length,
            time=f"{recording.imu.t[segment.place.start + start]:.2f}",
        )  # fmt: skip


def _longest_repeat(values: np.ndarray) -> tuple[int, int]:
    """First row and length of the longest run of one value."""
    changes = np.flatnonzero(np.diff(values)) + 1
    edges = np.concatenate(([0], changes, [len(values)]))
    lengths = np.diff(edges)
    longest = int(lengths.argmax())
    return int(edges[longest]), int(lengths[longest])


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
