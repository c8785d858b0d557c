"""How much information a partition of the run gives on where an excess sits, and its words.

The measure is the information in nats a row that the partition gives about the excess e, as of a
normal distribution. Power that concentrates in few cells: ½·Σ wₖ·ln(v/vₖ), wₖ the share of time,
v the mean square of e, vₖ its variance in cell k. An excess that varies with the cells:
½·ln(v/v′), v′ what a step for each cell leaves, fitted together with the standard's regressors,
which blur it. Each cell costs 1/N (Akaike's criterion), N the intervals of the run, by which
alone cells are told apart; the best of s that were searched costs ln s/N.
"""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.excess import ChannelExcess
from tasks.explain.locate.partition import Partition
from tasks.explain.locate.run import Moments, Run
from tasks.words import Message, message

FLOOR = 0.03  # of the mean square: smaller remainders do not count
MIN_HELD = 0.75  # of the power: a place that holds less gives way to a variation
TINY = 1e-300
MAX_LISTED = 4  # cells without an order that are named


@dataclass(frozen=True)
class Pattern:
    """One description of where an excess sits: its information (nats a row) less its cost.

    rows: (m,) bool, the blocks that it points at.
    """

    dimension: Dimension
    score: float
    description: Message
    rows: np.ndarray


def concentration(rows: np.ndarray, left: np.ndarray, whole: float) -> float:
    """Nats a row of cells with these rows and square sums (k,); whole: square sum of them all."""
    mean, some = whole / rows.sum(), np.maximum(rows, 1.0)
    nats = np.log((1 + FLOOR) * mean / (np.maximum(left, 0.0) / some + FLOOR * mean))
    return float(0.5 * (rows / rows.sum() * nats).sum())


def fit_information(share: float) -> float:
    """Nats a row of a fit that absorbs a share of the power."""
    return float(0.5 * np.log((1 + FLOOR) / (1 + FLOOR - np.clip(share, 0.0, 1.0))))


def cost(parameters: int, searched: int, intervals: int) -> float:
    """Nats a row that fitted parameters and searched alternatives cost."""
    return (parameters + float(np.log(searched))) / intervals


def partition_pattern(run: Run, partition: Partition, excess: ChannelExcess, tried: int) -> Pattern:
    """What a partition says of an excess; rows of unknown cell do not count."""
    known, count = partition.cell >= 0, len(partition.cells)
    cell = partition.cell[known]

    def per_cell(values: np.ndarray) -> np.ndarray:
        return np.bincount(cell, values[known], count)

    of_blocks = excess.moments
    cells = Moments(*map(per_cell, (of_blocks.rows, of_blocks.first, of_blocks.second)))
    sums = np.column_stack([per_cell(column) for column in excess.sums.T])
    steps, absorbed = excess.design.fit_steps(cells.rows, sums, cells.first)
    varies, gathers = fit_information(absorbed / excess.power), 0.0
    held = float(cells.second.sum())
    if held and not partition.recorded:
        left = cells.second - cells.first**2 / np.maximum(cells.rows, 1.0)
        gathers = held / excess.power * concentration(cells.rows, left, held)
    paid = cost(int((cells.rows > 0).sum()), tried, run.intervals)
    chosen = densest(cells, partition.ordered)
    share = float(cells.second[chosen].sum()) / excess.power
    if varies >= gathers or (share < MIN_HELD and absorbed > MIN_HELD * excess.power):
        description = _variation(partition, cells, steps, absorbed / excess.power, excess)
        return Pattern(partition.dimension, max(varies, gathers) - paid, description, known)
    time = float(cells.rows[chosen].sum() / of_blocks.rows.sum())
    description = message(
        "locate-concentrated", share=f"{share:.0%}", where=partition.circumstance(chosen),
        time=f"{time:.0%}" if time >= 0.01 else f"{time:.1%}",
    )  # fmt: skip
    rows = np.isin(partition.cell, chosen)
    return Pattern(partition.dimension, gathers - paid, description, rows)


def densest(cells: Moments, ordered: bool) -> list[int]:
    """The cells that hold most power above their share of time; of an order, neighbours."""
    above = cells.second / max(cells.second.sum(), TINY) - cells.rows / cells.rows.sum()
    if not ordered:
        chosen = sorted(int(k) for k in np.argsort(-above)[:MAX_LISTED] if above[k] > 0)
    else:
        reach = np.concatenate([[0.0], np.cumsum(above)])
        spans = np.triu(reach[None, :] - reach[:, None], 1)
        start, stop = np.unravel_index(int(spans.argmax()), spans.shape)
        chosen = [k for k in range(int(start), int(stop)) if cells.rows[k]]
    return chosen or [int(above.argmax())]


def _variation(
    partition: Partition, cells: Moments, steps: np.ndarray, share: float, excess: ChannelExcess
) -> Message:
    """«91 % of it follows the temperature: … at …, … at …»."""
    used = np.flatnonzero(cells.rows > 0)
    low, high = (int(used[k]) for k in (steps[used].argmin(), steps[used].argmax()))
    return message(
        "locate-variation", share=f"{share:.0%}", variable=partition.variable,
        least=excess.formatted(steps[low]), low=partition.cells[low],
        most=excess.formatted(steps[high]), high=partition.cells[high],
    )  # fmt: skip
