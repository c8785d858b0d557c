"""How well a way of parting the run tells where an excess sits, and what it then says.

The measure is the information that knowing the cell gives about the excess e, as of a normal
distribution: ½·Σ wₖ·ln(v/vₖ), wₖ the share of time, v the mean square of e, vₖ its variance
about its own mean in cell k. It is large where the power sits in few cells and where e goes by
the cell. Each cell costs 1/N (Akaike's criterion), N the stretches of the run, by which alone
cells are told apart; the best of s that were searched costs ln s/N.
"""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.regime import Regime
from tasks.explain.locate.run import Run, Sums
from tasks.model.term import Text

CONCENTRATED = 0.6  # power share above time share from which a place is named, not a course
FOLLOWING = 0.5  # share of the power in the cells' means from which the excess goes by them
GOES_BY = 0.6  # the same for what the run did not command
LISTED = 4  # cells of no order that are named
EARLIEST_CUT = 0.02  # of the run


@dataclass(frozen=True)
class View:
    """How a course is looked at. floor: of its mean square, below which nothing counts.

    factor, unit: to print its values.
    """

    floor: float
    factor: float
    unit: str


@dataclass(frozen=True)
class Pattern:
    """One way of saying where: how much it tells (nats a row, paid for), and in words.

    rows: (m,) bool, the blocks that it points at.
    """

    dimension: Dimension
    score: float
    text: Text
    rows: np.ndarray


def told(rows: np.ndarray, left: np.ndarray, whole: float, floor: float) -> float:
    """Nats a row. rows, left: (k,) of the cells, left the square sum; whole: of all of them.

    floor: of the mean square; smaller remainders do not count.
    """
    mean, some = whole / rows.sum(), np.maximum(rows, 1.0)
    return float(
        0.5 * (rows / rows.sum() * np.log((1 + floor) * mean / (left / some + floor * mean))).sum()
    )


def paid(numbers: int, searched: int, pieces: int) -> float:
    """What numbers that were fitted and places that were searched cost, nats a row."""
    return (numbers + float(np.log(searched))) / pieces


def by_regime(run: Run, regime: Regime, sums: Sums, view: View, tried: int) -> Pattern:
    """What a regime tells of an excess; of rows whose cell is not known it tells nothing."""
    known, count = regime.cell >= 0, len(regime.cells)
    cells = Sums(*(
        np.bincount(regime.cell[known], each[known], count)
        for each in (sums.rows, sums.first, sums.second)
    ))  # fmt: skip
    rows, held, whole = cells.rows.sum(), cells.second.sum(), float(sums.second.sum())
    if not held:
        return Pattern(regime.dimension, 0.0, ("", ""), known)
    left = cells.second - cells.first**2 / np.maximum(cells.rows, 1.0)
    following = 1.0 - float(left.sum() / held)
    if regime.recorded and following < GOES_BY:
        left = left.sum() * cells.rows / rows
    cost = paid(int((cells.rows > 0).sum()), tried, run.pieces)
    score = held / whole * told(cells.rows, np.maximum(left, 0.0), held, view.floor) - cost
    chosen, above = densest(cells, regime.ordered)
    if regime.recorded or (above < CONCENTRATED and following > FOLLOWING):
        text = _course(regime, cells, following * held / whole, view)
        return Pattern(regime.dimension, score, text, known)
    share = float(cells.second[chosen].sum() / whole)
    time = float(cells.rows[chosen].sum() / sums.rows.sum())
    place = regime.at(chosen)
    text = (
        f"{share:.0%} of it {place[0]}, {_percent(time)} of the time",
        f"{place[1]}占 {share:.0%}，而时间只占 {_percent(time)}",
    )
    return Pattern(regime.dimension, score, text, np.isin(regime.cell, chosen))


def _percent(share: float) -> str:
    return f"{share:.0%}" if share >= 0.01 else f"{share:.1%}"


def densest(cells: Sums, ordered: bool) -> tuple[list[int], float]:
    """The cells that hold most power above their share of time, and how much above.

    Of an order they lie next to each other.
    """
    above = cells.second / cells.second.sum() - cells.rows / cells.rows.sum()
    if not ordered:
        chosen = sorted(int(k) for k in np.argsort(-above)[:LISTED] if above[k] > 0)
    else:
        reach = np.concatenate([[0.0], np.cumsum(above)])
        spans = np.triu(reach[None, :] - reach[:, None], 1)
        start, stop = np.unravel_index(int(spans.argmax()), spans.shape)
        chosen = [k for k in range(int(start), int(stop)) if cells.rows[k]]
    return chosen or [int(above.argmax())], float(above[chosen].sum())


def _course(regime: Regime, cells: Sums, following: float, view: View) -> Text:
    """«91 % of it follows the temperature: from … at … to … at …»."""
    used = np.flatnonzero(cells.rows > 0)
    means = cells.first[used] / cells.rows[used] * view.factor
    ends = [regime.cells[used[each]] for each in (means.argmin(), means.argmax())]
    least, most = (f"{each:+.2g} {view.unit}" for each in (means.min(), means.max()))
    return (
        f"{following:.0%} of it follows {regime.follows[0]}: "
        f"{least} {ends[0][0]}, {most} {ends[1][0]}",
        f"{following:.0%} 随{regime.follows[1]}变化：{ends[0][1]} {least}，{ends[1][1]} {most}",
    )


def by_cut(run: Run, sums: Sums, view: View) -> Pattern | None:
    """The moment before and after which the excess differs most."""
    ends = [np.cumsum(each) for each in (sums.rows, sums.first, sums.second)]
    inside = (ends[0] > EARLIEST_CUT * ends[0][-1]) & (ends[0] < (1 - EARLIEST_CUT) * ends[0][-1])
    at = np.flatnonzero(inside)
    if not len(at):
        return None
    before = [each[at] for each in ends]
    after = [each[-1] - part for each, part in zip(ends, before, strict=True)]
    rows = np.stack([before[0], after[0]])
    left = np.stack([each[2] - each[1] ** 2 / each[0] for each in (before, after)])
    mean = ends[2][-1] / ends[0][-1]
    each = np.log((1 + view.floor) * mean / (np.maximum(left, 0) / rows + view.floor * mean))
    scores = 0.5 * (rows / ends[0][-1] * each).sum(axis=0)
    best = int(scores.argmax())
    cut = float(run.t[at[best]])
    score = float(scores[best]) - paid(2, run.pieces, run.pieces)
    means = [part[1][best] / part[0][best] * view.factor for part in (before, after)]
    powers = [float(part[2][best] / ends[2][-1]) for part in (before, after)]
    old, new = (f"{each:+.2g} {view.unit}" for each in means)
    later = powers[1] >= powers[0]
    text = (
        f"{max(powers):.0%} of it {'after' if later else 'before'} {cut:.4g} s: "
        f"{old} before, {new} after",
        f"{max(powers):.0%} 在 {cut:.4g} s {'之后' if later else '之前'}：之前 {old}，之后 {new}",
    )
    return Pattern("time", score, text, (run.t > cut) == later)
