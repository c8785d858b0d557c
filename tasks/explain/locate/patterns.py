"""Patterns in an excess, and how much each tells about its location.

The measure is the information in nats a row that a pattern gives about the excess e, as of a
normal distribution. Power that concentrates in few cells: ½·Σ wₖ·ln(v/vₖ), wₖ the share of time,
v the mean square of e, vₖ its variance in cell k. An excess that varies with the cells:
½·ln(v/v′), v′ what a step for each cell leaves, fitted together with the standard's regressors,
which blur it. Each cell costs 1/N (Akaike's criterion), N the intervals of the run, by which
alone cells are told apart; the best of s that were searched costs ln s/N.
"""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.partitions import Partition
from tasks.explain.locate.run_blocks import (
    MAX_HARMONIC,
    MIN_VISIBLE,
    BlockedRun,
    ChannelExcess,
    Moments,
    Rotation,
)
from tasks.words import Message, message
from tasks.words.quantities import moment, percent

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
