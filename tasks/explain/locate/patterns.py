"""How well a way of parting the run tells where an excess sits, and what it then says.

The measure is the information in nats a row that the parting gives about the excess e, as of a
normal distribution. Power that sits in few cells: ½·Σ wₖ·ln(v/vₖ), wₖ the share of time, v the
mean square of e, vₖ its variance in cell k. A course that goes by the cells: ½·ln(v/v′), v′ what
a step for each cell leaves, fitted together with the standard's columns, which blur it. Each cell
costs 1/N (Akaike's criterion), N the stretches of the run, by which alone cells are told apart;
the best of s that were searched costs ln s/N.
"""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.excess import Columns
from tasks.explain.locate.regime import Regime
from tasks.explain.locate.run import Run, Sums
from tasks.model.term import Text

FLOOR = 0.03  # of the mean square: smaller remainders do not count
MOST = 0.75  # of the power: a place that holds less does not say it, where a course does
TINY = 1e-300
LISTED = 4  # cells of no order that are named


@dataclass(frozen=True)
class Pattern:
    """One way of saying where: how much it tells (nats a row, paid for), and in words.

    rows: (m,) bool, the blocks that it points at.
    """

    dimension: Dimension
    score: float
    text: Text
    rows: np.ndarray


@dataclass(frozen=True)
class Seen:
    """One channel's excess, and what it is seen with.

    course: (n,) in standard deviations. sums: of its blocks. columns: the standard's, and their
    sums (m, k) over the blocks, `within`. factor, unit: to print a value of the course.
    """

    course: np.ndarray
    sums: Sums
    columns: Columns
    within: np.ndarray
    factor: float
    unit: str

    @property
    def power(self) -> float:
        """The square sum."""
        return float(self.sums.second.sum())

    def shown(self, value: float) -> str:
        """A value of the course with its sign and unit."""
        return f"{value * self.factor:+.2g} {self.unit}"


def gathered(rows: np.ndarray, left: np.ndarray, whole: float) -> float:
    """Nats a row that cells tell whose rows and square sums (k,) these are; whole: of them all."""
    mean, some = whole / rows.sum(), np.maximum(rows, 1.0)
    told = np.log((1 + FLOOR) * mean / (np.maximum(left, 0.0) / some + FLOOR * mean))
    return float(0.5 * (rows / rows.sum() * told).sum())


def followed(share: float) -> float:
    """Nats a row that a fit tells which takes up a share of the power."""
    return float(0.5 * np.log((1 + FLOOR) / (1 + FLOOR - np.clip(share, 0.0, 1.0))))


def paid(numbers: int, searched: int, pieces: int) -> float:
    """What numbers that were fitted and places that were searched cost, nats a row."""
    return (numbers + float(np.log(searched))) / pieces


def by_regime(run: Run, regime: Regime, seen: Seen, tried: int) -> Pattern:
    """What a regime tells of an excess; of rows whose cell is not known it tells nothing."""
    known, count = regime.cell >= 0, len(regime.cells)
    cell = regime.cell[known]

    def each(values: np.ndarray) -> np.ndarray:
        return np.bincount(cell, values[known], count)

    cells = Sums(each(seen.sums.rows), each(seen.sums.first), each(seen.sums.second))
    within = np.column_stack([each(column) for column in seen.within.T])
    steps, taken = seen.columns.pattern(cells.rows, within, cells.first)
    cost = paid(int((cells.rows > 0).sum()), tried, run.pieces)
    follows, gathers = followed(taken / seen.power), 0.0
    held = float(cells.second.sum())
    if held and not regime.recorded:
        left = cells.second - cells.first**2 / np.maximum(cells.rows, 1.0)
        gathers = held / seen.power * gathered(cells.rows, left, held)
    chosen = densest(cells, regime.ordered)
    share = float(cells.second[chosen].sum()) / seen.power
    if follows >= gathers or (share < MOST and taken > MOST * seen.power):
        text = _course(regime, cells, steps, taken / seen.power, seen)
        return Pattern(regime.dimension, max(follows, gathers) - cost, text, known)
    time = float(cells.rows[chosen].sum() / seen.sums.rows.sum())
    place = regime.at(chosen)
    text = (
        f"{share:.0%} of it {place[0]}, {_percent(time)} of the time",
        f"{place[1]}占 {share:.0%}，而时间只占 {_percent(time)}",
    )
    return Pattern(regime.dimension, gathers - cost, text, np.isin(regime.cell, chosen))


def _percent(share: float) -> str:
    return f"{share:.0%}" if share >= 0.01 else f"{share:.1%}"


def densest(cells: Sums, ordered: bool) -> list[int]:
    """The cells that hold most power above their share of time; of an order, neighbours."""
    above = cells.second / max(cells.second.sum(), TINY) - cells.rows / cells.rows.sum()
    if not ordered:
        chosen = sorted(int(k) for k in np.argsort(-above)[:LISTED] if above[k] > 0)
    else:
        reach = np.concatenate([[0.0], np.cumsum(above)])
        spans = np.triu(reach[None, :] - reach[:, None], 1)
        start, stop = np.unravel_index(int(spans.argmax()), spans.shape)
        chosen = [k for k in range(int(start), int(stop)) if cells.rows[k]]
    return chosen or [int(above.argmax())]


def _course(regime: Regime, cells: Sums, steps: np.ndarray, share: float, seen: Seen) -> Text:
    """«91 % of it follows the temperature: … at …, … at …»."""
    used = np.flatnonzero(cells.rows > 0)
    low, high = (int(used[k]) for k in (steps[used].argmin(), steps[used].argmax()))
    least, most = seen.shown(steps[low]), seen.shown(steps[high])
    english, chinese = regime.follows
    return (
        f"{share:.0%} of it follows {english}: "
        f"{least} {regime.cells[low][0]}, {most} {regime.cells[high][0]}",
        f"{share:.0%} 随{chinese}变化："
        f"{regime.cells[low][1]} {least}，{regime.cells[high][1]} {most}",
    )
