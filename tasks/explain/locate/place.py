"""The one way of saying where an excess sits that tells most."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.patterns import Pattern, by_cut, by_regime
from tasks.explain.locate.run import Run, Sums
from tasks.explain.locate.waves import by_frequency, by_turns
from tasks.model.term import Text

TELLING = 0.1  # nats a row: what tells less is no pattern
NAMED = 8  # segments in an entry
MOST = 0.9  # of the power: segments beyond are not named
PARTS = 100  # of the run
IN_STRETCHES = 0.7  # share in the densest fifth of them from which it comes in stretches
LEVEL: Text = ("everywhere alike", "各处相同")


@dataclass(frozen=True)
class Place:
    """Where one channel's part of an excess sits."""

    dimension: Dimension
    description: Text
    segments: tuple[str, ...]


def patterns_in(
    run: Run, excess: np.ndarray, channel: int, noise: float
) -> Mapping[Dimension, Pattern]:
    """The best pattern of each dimension in one channel's excess (n,), in standard deviations.

    noise: rad/s or m/s², one standard deviation.
    """
    unit = (float(np.degrees(noise)), "°/s") if channel < 3 else (noise, "m/s²")
    sums = run.sums(excess)
    tried = Counter(regime.dimension for regime in run.regimes)
    every = [
        by_regime(run, regime, sums, unit, tried[regime.dimension]) for regime in run.regimes
    ]
    every += [by_turns(run, turns, excess, sums) for turns in run.turns]
    more = (by_cut(run, sums, unit), by_frequency(run, excess, sums))
    every += [each for each in more if each is not None]
    every.sort(key=lambda each: each.score)
    return {each.dimension: each for each in every}


def places(
    run: Run, found: Mapping[int, Mapping[Dimension, Pattern]], excess: np.ndarray
) -> dict[int, Place]:
    """The place of each channel's part of one finding.

    found: the patterns of each channel that it touches. excess: (n, 6). One physics is seen in
    all of them, so that a dimension counts in a channel by what it tells there and, as much, by
    what it tells in all, weighted by their power.
    """
    power = (excess**2).sum(axis=0)
    whole = sum(power[channel] for channel in found)
    together: Counter[Dimension] = Counter()
    for channel, each in found.items():
        for dimension, pattern in each.items():
            together[dimension] += power[channel] / whole * pattern.score
    placed = {}
    for channel, each in found.items():
        best = max(each.values(), key=lambda p: p.score + together[p.dimension], default=None)
        placed[channel] = _place(run, best, run.sums(excess[:, channel]))
    return placed


def _place(run: Run, best: Pattern | None, sums: Sums) -> Place:
    if best is None or best.score < TELLING:
        return _without_pattern(run, sums)
    return Place(best.dimension, best.text, _holding(run, sums, best.rows))


def _without_pattern(run: Run, sums: Sums) -> Place:
    """In short stretches of the run that nothing else tells apart, or everywhere alike."""
    part = np.minimum(PARTS * np.arange(len(run.t)) // len(run.t), PARTS - 1)
    power = np.bincount(part, sums.second, PARTS)
    densest = np.argsort(-power)[: PARTS // 5]
    share = float(power[densest].sum() / power.sum())
    rows = np.isin(part, densest)
    if share < IN_STRETCHES:
        return Place("level", LEVEL, _holding(run, sums, np.ones(len(run.t), bool)))
    text = f"{share:.0%} of it in a fifth of the time, in short stretches", (
        f"{share:.0%} 出现在仅占总时间五分之一的若干短时段内"
    )
    return Place("time", text, _holding(run, sums, rows))


def _holding(run: Run, sums: Sums, rows: np.ndarray) -> tuple[str, ...]:
    """The segments that hold most of the power at some blocks, by falling power."""
    inside = rows & (run.segment >= 0)
    power = np.bincount(run.segment[inside], sums.second[inside], len(run.names))
    order = np.argsort(-power, kind="stable")[:NAMED]
    before = np.cumsum(power[order]) - power[order]
    kept = (power[order] > 0) & (before < MOST * power.sum())
    return tuple(run.names[k] for k in order[kept])
