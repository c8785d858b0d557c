"""Describes where the excess of a finding lies: channel, circumstances and segments.

The excess of a finding is what the standard's model cannot absorb of its contribution. Each
channel's part of it is compared with every way of partitioning the run (by rate, by attitude, by
temperature …); the one that leaves least unexplained is where it sits.
"""

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import linregress

from schemas.discrepancy import Dimension, Where
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.shares import is_drift
from tasks.explain.explanation import Explanation, Finding
from tasks.explain.locate.partitions import time_since_move
from tasks.explain.locate.patterns import (
    Pattern,
    change_point_pattern,
    frequency_pattern,
    harmonics_pattern,
    partition_pattern,
)
from tasks.explain.locate.run_blocks import (
    BlockedRun,
    ChannelExcess,
    Moments,
    StandardDesign,
    noise_scales,
)
from tasks.motion.whole import Motion
from tasks.words import Message, message, statement
from tasks.words.quantities import percent

MIN_SHARE = 0.05  # of a finding's excess, from which a channel has an entry of its own
NEGLIGIBLE = 1e-4  # share of the other channels together that is not worth an entry
ROUNDING = 1e-6  # square sum, in variances of the noise, that is arithmetic


@dataclass(frozen=True)
class Place:
    """Where one channel's part of an excess sits."""

    dimension: Dimension
    description: Message
    segments: tuple[str, ...]


ABSORBED = Place("level", message("locate-absorbed"), ())
SLIGHT = Place("level", message("locate-slight"), ())
MIN_SCORE = 0.1  # nats a row: what carries less is no pattern
MAX_SEGMENTS = 8  # in an entry
ENOUGH = 0.9  # of the power: segments beyond are not named
PARTS = 100  # of the run
INTERMITTENT = 0.7  # share in the densest fifth of them from which it comes in short intervals
LONGEST_SETTLING = 60  # s after a move that are looked at
MIN_ROWS, MIN_SECONDS = 10, 6  # in a second, and those with so many, that settling is read off
MIN_R_SQUARED = 0.95  # of a line through the logarithm: less is no exponential
MIN_POWER = 1e-4  # of the largest
UNIFORM = message("locate-uniform")


def locate(explanation: Explanation) -> tuple[tuple[Where, ...], ...]:
    """For each finding where its excess sits, by falling share; the shares add up to 1.

    A channel with 5 % or more of the excess has one entry, its share that of the channel. What
    the others hold is a last entry of dimension “level”, their names separated by commas. A
    finding without excess has one entry, “level”, at its first channel.
    """
    if not explanation.findings:
        return ()
    run = BlockedRun.of(explanation.recording)
    designs = tuple(StandardDesign.of(run, channel) for channel in range(len(CHANNELS)))
    noise = noise_scales(explanation.noise)
    return tuple(
        _entries(run, finding, _signal(finding, explanation), designs, noise)
        for finding in explanation.findings
    )


def _signal(finding: Finding, explanation: Explanation) -> np.ndarray:
    """(n, 6) what is located: a finding's contribution; of what nothing explains, the residual in
    its channels.
    """
    if not finding.remainder:
        return finding.contribution
    residual = explanation.recording.imu.stack(CHANNELS) - explanation.found
    return np.where(np.isin(np.arange(len(CHANNELS)), finding.channels), residual, 0.0)


def _entries(
    run: BlockedRun, finding: Finding, signal: np.ndarray, designs: tuple[StandardDesign, ...],
    noise: np.ndarray,
) -> tuple[Where, ...]:  # fmt: skip
    """signal: (n, 6) to be located. noise: (6,) standard deviations, which it is counted in."""
    scaled = signal / noise
    columns = scaled.T
    designs = tuple(each.at_known(run, c) for each, c in zip(designs, columns, strict=True))
    excess = [design.residual(column) for design, column in zip(designs, columns, strict=True)]
    power = np.array([float((values**2).sum()) for values in excess])
    if power.sum() < ROUNDING:
        return (_where(CHANNELS[(*finding.channels, 0)[0]], ABSORBED, 1.0),)
    share = power / power.sum()
    major = [int(c) for c in np.argsort(-share) if share[c] >= MIN_SHARE]
    channels = {c: ChannelExcess.of(run, excess[c], designs[c], c, float(noise[c])) for c in major}
    placed = places(run, channels, signal, by_time=is_drift(finding))
    entries = [_where(CHANNELS[c], placed[c], float(share[c])) for c in major]
    rest = 1.0 - sum(each.share for each in entries)
    if rest > NEGLIGIBLE:
        slight = ", ".join(CHANNELS[c] for c in range(6) if 0 < share[c] < MIN_SHARE)
        return (*entries, _where(slight, SLIGHT, rest))
    first = entries[0].model_copy(update={"share": entries[0].share + rest})
    return (first, *entries[1:])


def _where(channel: str, place: Place, share: float) -> Where:
    return Where(
        channel=channel, dimension=place.dimension, description=statement(place.description),
        segments=place.segments, share=share,
    )  # fmt: skip


def places(
    run: BlockedRun, channels: Mapping[int, ChannelExcess], contribution: np.ndarray,
    by_time: bool = False,
) -> dict[int, Place]:  # fmt: skip
    """The place of each channel's part of one finding; contribution: (n, 6). by_time: no
    other partition is asked than that by time.

    A pattern counts by its information on the channel's excess, and its dimension by that on all
    channels, for one physics acts in all of them.
    """
    if by_time:
        run = replace(run, partitions=tuple(p for p in run.partitions if p.dimension == "time"))
    patterns = {channel: _patterns(run, excess) for channel, excess in channels.items()}
    power = sum(excess.power for excess in channels.values())
    votes: defaultdict[Dimension, float] = defaultdict(float)
    for channel, own in patterns.items():
        best = {each.dimension: each.score for each in sorted(own, key=lambda each: each.score)}
        for dimension, score in best.items():
            votes[dimension] += channels[channel].power / power * score
    return {
        channel: _place(
            run,
            max(own, key=lambda each: each.score + votes[each.dimension], default=None),
            channels[channel].moments,
            contribution[:, channel],
        )
        for channel, own in patterns.items()
    }


def _patterns(run: BlockedRun, excess: ChannelExcess) -> list[Pattern]:
    """Every pattern of one channel's excess that carries enough information."""
    tried = Counter(partition.dimension for partition in run.partitions)
    every = [
        *(partition_pattern(run, each, excess, tried[each.dimension]) for each in run.partitions),
        *(harmonics_pattern(run, rotation, excess) for rotation in run.rotations),
        change_point_pattern(run, excess),
        frequency_pattern(run, excess),
    ]
    return [each for each in every if each is not None and each.score >= MIN_SCORE]


def _place(
    run: BlockedRun, best: Pattern | None, excess: Moments, contribution: np.ndarray
) -> Place:
    if best is None:
        return _without_pattern(run, excess)
    description = best.description
    if best.dimension == "after_moves":
        seconds = settling_time(run.motion, contribution)
        if seconds is not None:
            description = message("locate-settling", where=description, seconds=f"{seconds:.2g}")
    return Place(best.dimension, description, _main_segments(run, excess, best.rows))


def _without_pattern(run: BlockedRun, excess: Moments) -> Place:
    """In short intervals of the run that no pattern describes, or everywhere alike."""
    part = np.minimum(PARTS * np.arange(len(run.t)) // len(run.t), PARTS - 1)
    power = np.bincount(part, excess.second, PARTS)
    densest = np.argsort(-power)[: PARTS // 5]
    share = float(power[densest].sum() / power.sum())
    if share < INTERMITTENT:
        return Place("level", UNIFORM, _main_segments(run, excess, np.ones(len(run.t), bool)))
    description = message("locate-intermittent", share=percent(share))
    return Place("time", description, _main_segments(run, excess, np.isin(part, densest)))


def _main_segments(run: BlockedRun, excess: Moments, rows: np.ndarray) -> tuple[str, ...]:
    """The segments that hold most of the power at some blocks, by falling power."""
    inside = rows & (run.segment >= 0)
    power = np.bincount(run.segment[inside], excess.second[inside], len(run.names))
    order = np.argsort(-power, kind="stable")[:MAX_SEGMENTS]
    before = np.cumsum(power[order]) - power[order]
    kept = (power[order] > 0) & (before < ENOUGH * power.sum())
    return tuple(run.names[k] for k in order[kept])


def settling_time(motion: Motion, signal: np.ndarray) -> float | None:
    """Time constant (s) of a signal (n,), None where it does not settle exponentially.

    Moves may start it with any size and sign: of A·exp(−s/τ) the mean square over all moves
    falls as exp(−2·s/τ), s the time since the move.
    """
    since = time_since_move(motion)
    known = (since > 0) & (since < LONGEST_SETTLING)
    second = since[known].astype(int)
    rows = np.bincount(second, minlength=LONGEST_SETTLING)
    power = np.bincount(second, signal[known] ** 2, LONGEST_SETTLING) / np.maximum(rows, 1)
    used = (rows >= MIN_ROWS) & (power > MIN_POWER * power.max())
    if used.sum() < MIN_SECONDS:
        return None
    line = linregress(np.flatnonzero(used) + 0.5, np.log(power[used]))
    if line.slope >= 0 or line.rvalue**2 < MIN_R_SQUARED:
        return None
    return float(-2.0 / line.slope)
