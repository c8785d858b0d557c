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
from tasks.explain.evidence.findings import is_drift
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.explain.locate.partitions import (
    MAX_HARMONIC,
    MIN_VISIBLE,
    BlockedRun,
    ChannelExcess,
    Moments,
    Partition,
    Rotation,
    StandardDesign,
    noise_scales,
    time_since_move,
)
from tasks.motion.whole import Motion
from tasks.words import Message, message, statement
from tasks.words.numbers import moment, percent

# Patterns in an excess, and how much each tells about its location.
#
# The measure is the information in nats a row that a pattern gives about the excess e, as of a
# normal distribution. Power that concentrates in few cells: ½·Σ wₖ·ln(v/vₖ), wₖ the share of
# time, v the mean square of e, vₖ its variance in cell k. An excess that varies with the cells:
# ½·ln(v/v′), v′ what a step for each cell leaves, fitted together with the standard's regressors,
# which blur it. Each cell costs 1/N (Akaike's criterion), N the intervals of the run, by which
# alone cells are told apart; the best of s that were searched costs ln s/N.

FLOOR = 0.03  # of the mean square: smaller remainders do not count
MIN_HELD = 0.75  # of the power: a place that holds less gives way to a variation
TINY = 1e-300
MAX_CELLS = 4  # without an order that are named
MARGIN = 0.02  # of the run at either end, without change points
MAX_HARMONICS = 3  # numbers of waves that are named together
MIN_RELATIVE = 0.2  # of the strongest, from which a further number of waves is named beside it
MIN_PERIODS = 8  # in the run: slower is a trend
WIDTH, BESIDE = 0.005, 2  # of the frequency, and lines beside it, that belong to it


@dataclass(frozen=True)
class Pattern:
    """One description of where an excess sits: its information (nats a row) less its cost.

    rows: (m,) bool, the blocks that it points at.
    """

    dimension: Dimension
    score: float
    description: Message
    rows: np.ndarray


def concentration(rows: np.ndarray, left: np.ndarray, whole: float) -> np.ndarray:
    """Nats a row of k cells with these rows and square sums (k, …); whole: square sum of all."""
    share = rows / rows.sum(axis=0)
    mean = whole / rows.sum(axis=0)
    variance = np.maximum(left, 0.0) / np.maximum(rows, 1.0)
    nats = np.log((1 + FLOOR) * mean / (variance + FLOOR * mean))
    return np.asarray(0.5 * (share * nats).sum(axis=0))


def fit_information(share: float) -> float:
    """Nats a row of a fit that absorbs a share of the power."""
    return float(0.5 * np.log((1 + FLOOR) / (1 + FLOOR - np.clip(share, 0.0, 1.0))))


def cost(parameters: int, searched: int, intervals: int) -> float:
    """Nats a row that fitted parameters and searched alternatives cost."""
    return (parameters + float(np.log(searched))) / intervals


def partition_pattern(
    run: BlockedRun, partition: Partition, excess: ChannelExcess, tried: int
) -> Pattern:
    """What a partition says of an excess; rows of unknown cell do not count."""
    blocks = excess.moments
    cells = Moments(*(partition.indicator @ v for v in (blocks.rows, blocks.first, blocks.second)))
    sums = partition.indicator @ excess.design.sums
    steps, absorbed = excess.design.fit_steps(cells.rows, sums, cells.first)
    absorbed = min(absorbed, excess.power)  # steps that the regressors nearly are absorb no more
    varies, gathers = fit_information(absorbed / excess.power), 0.0
    held = float(cells.second.sum())
    if held and not partition.recorded:
        left = cells.second - cells.first**2 / np.maximum(cells.rows, 1.0)
        gathers = held / excess.power * float(concentration(cells.rows, left, held))
    paid = cost(int((cells.rows > 0).sum()), tried, run.intervals)
    chosen = densest(cells, partition.ordered)
    share = float(cells.second[chosen].sum()) / excess.power
    if varies >= gathers or (share < MIN_HELD and absorbed > MIN_HELD * excess.power):
        description = _variation(partition, cells, steps, absorbed / excess.power, excess)
        known = partition.cell >= 0
        return Pattern(partition.dimension, max(varies, gathers) - paid, description, known)
    time = float(cells.rows[chosen].sum() / blocks.rows.sum())
    description = message(
        "locate-concentrated", share=percent(share), where=partition.circumstance(chosen),
        time=percent(time),
    )  # fmt: skip
    rows = np.isin(partition.cell, chosen)
    return Pattern(partition.dimension, gathers - paid, description, rows)


def densest(cells: Moments, ordered: bool) -> list[int]:
    """The cells that hold most power above their share of time; of an order, neighbours."""
    above = cells.second / max(cells.second.sum(), TINY) - cells.rows / cells.rows.sum()
    if not ordered:
        chosen = sorted(int(k) for k in np.argsort(-above)[:MAX_CELLS] if above[k] > 0)
    else:
        reach = np.concatenate([[0.0], np.cumsum(above)])
        spans = np.triu(reach[None, :] - reach[:, None], 1)
        start, stop = np.unravel_index(int(spans.argmax()), spans.shape)
        chosen = [k for k in range(int(start), int(stop)) if cells.rows[k]]
    return chosen or [int(above.argmax())]


def _variation(
    partition: Partition, cells: Moments, steps: np.ndarray, share: float, excess: ChannelExcess
) -> Message:
    """“91 % of it follows the temperature: … at …, … at …”."""
    used = np.flatnonzero(cells.rows > 0)
    low, high = (int(used[k]) for k in (steps[used].argmin(), steps[used].argmax()))
    return message(
        "locate-variation", share=percent(share), variable=partition.variable,
        least=excess.formatted(steps[low]), low=partition.cells[low],
        most=excess.formatted(steps[high]), high=partition.cells[high],
    )  # fmt: skip


def change_point_pattern(run: BlockedRun, excess: ChannelExcess) -> Pattern | None:
    """A step at the moment that absorbs most, or the moment that parts the power best."""
    moments = excess.moments
    ends = np.cumsum([moments.rows, moments.first, moments.second], axis=1)
    share = ends[0] / ends[0, -1]
    at = np.flatnonzero((share > MARGIN) & (share < 1 - MARGIN))
    if not len(at):
        return None
    # Of what is before and after each moment, (2, moments) each.
    rows, first, second = np.stack([ends[:, at], ends[:, -1:] - ends[:, at]], axis=1)
    parted = concentration(rows, second - first**2 / rows, ends[2, -1])
    sums = np.cumsum(excess.design.sums, axis=0)[at]
    left = rows[0] - np.einsum("mi,ij,mj->m", sums, excess.design.inverse, sums)
    left = np.maximum(left, MIN_VISIBLE * rows[0])
    absorbed = first[0] ** 2 / left / excess.power
    absorbed = np.where(absorbed <= 1.0, absorbed, 0.0)  # a step that the standard's model has too
    paid = cost(2, run.intervals, run.intervals)
    best, split = int(absorbed.argmax()), int(parted.argmax())
    information = fit_information(float(absorbed[best]))
    if information >= parted[split]:
        description = message(
            "locate-step", share=percent(float(absorbed[best])),
            time=moment(float(run.t[at[best]])),
            step=excess.formatted(-float(first[0, best] / left[best])),
        )  # fmt: skip
        return Pattern("time", information - paid, description, np.ones(len(run.t), bool))
    time, after = float(run.t[at[split]]), float(second[1, split] / ends[2, -1])
    later = after >= 0.5
    description = message(
        "locate-after" if later else "locate-before",
        share=percent(max(after, 1 - after)), time=moment(time),
    )  # fmt: skip
    return Pattern("time", float(parted[split]) - paid, description, (run.t > time) == later)


def harmonics_pattern(run: BlockedRun, rotation: Rotation, excess: ChannelExcess) -> Pattern:
    """The numbers of waves per turn of an axis that hold most of an excess."""
    values, whole = excess.values, excess.power
    power = rotation.harmonic_power(values)
    order = np.argsort(-power)[:MAX_HARMONICS]
    kept = order[power[order] >= MIN_RELATIVE * power[order[0]]]
    turning = float((values[rotation.rows] ** 2).sum())
    held = min(float(power[kept].sum()), turning)
    rows = np.array([len(rotation.rows), len(values) - len(rotation.rows)], float)
    left = np.array([turning - held, whole - turning])
    paid = cost(2 * len(kept), MAX_HARMONIC, run.intervals)
    numbers = dict(zip(("first", "second", "third"), map(str, sorted(kept + 1)), strict=False))
    waves = "locate-one-wave" if kept.tolist() == [0] else f"locate-waves-{len(kept)}"
    description = message(
        "locate-harmonics", share=percent(held / whole), waves=message(waves, **numbers),
        axis=rotation.name,
    )  # fmt: skip
    mask = np.zeros(len(values), bool)
    mask[rotation.rows] = True
    score = float(concentration(rows, left, whole)) - paid
    return Pattern("rotation_phase", score, description, mask[run.starts])


def frequency_pattern(run: BlockedRun, excess: ChannelExcess) -> Pattern | None:
    """The frequency at which an excess has most of its power."""
    count = len(excess.values)
    power = np.abs(np.fft.rfft(excess.values)) ** 2
    if len(power) < 2 * MIN_PERIODS or count < 2:
        return None
    power[1 : (count + 1) // 2] *= 2
    lines = np.arange(MIN_PERIODS, len(power))
    reach = BESIDE + (WIDTH * lines).astype(int)
    summed = np.concatenate([[0.0], np.cumsum(power)])
    held = summed[np.minimum(lines + reach + 1, len(power))] - summed[lines - reach]
    most = int(held.argmax())
    share = float(held[most] / power.sum())
    band = slice(lines[most] - reach[most], lines[most] + reach[most] + 1)
    line = band.start + int(power[band].argmax())
    around = np.arange(line - 1, min(line + 2, len(power)))
    hertz = float(around @ power[around] / power[around].sum()) / (count * run.motion.interval)
    description = message("locate-frequency", share=percent(share), frequency=f"{hertz:.4g}")
    score = fit_information(share) - cost(2, len(lines), run.intervals)
    return Pattern("frequency", score, description, np.ones(len(run.t), bool))


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
