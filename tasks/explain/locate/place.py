"""The one way of saying where an excess sits that tells most."""

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.cut import by_cut
from tasks.explain.locate.fading import fading
from tasks.explain.locate.patterns import Pattern, Seen, by_regime
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


def patterns_in(run: Run, seen: Seen) -> list[Pattern]:
    """Every way of saying where one channel's excess sits that tells enough."""
    tried = Counter(regime.dimension for regime in run.regimes)
    every = [by_regime(run, each, seen, tried[each.dimension]) for each in run.regimes]
    every += [by_turns(run, turns, seen) for turns in run.turns]
    every += [each for each in (by_cut(run, seen), by_frequency(run, seen)) if each is not None]
    return [each for each in every if each.score >= TELLING]


def places(run: Run, channels: Mapping[int, Seen], contribution: np.ndarray) -> dict[int, Place]:
    """The place of each channel's part of one finding; contribution: (n, 6).

    A pattern counts by what it tells of the channel's excess, and its dimension by what it tells
    in all channels, for one physics is seen in all of them.
    """
    found = {channel: patterns_in(run, seen) for channel, seen in channels.items()}
    power = sum(seen.power for seen in channels.values())
    votes: defaultdict[Dimension, float] = defaultdict(float)
    for channel, ways in found.items():
        best = {way.dimension: way.score for way in sorted(ways, key=lambda each: each.score)}
        for dimension, score in best.items():
            votes[dimension] += channels[channel].power / power * score
    placed = {}
    for channel, ways in found.items():
        most = max(ways, key=lambda each: each.score + votes[each.dimension], default=None)
        placed[channel] = _place(run, most, channels[channel].sums, contribution[:, channel])
    return placed


def _place(run: Run, best: Pattern | None, sums: Sums, contribution: np.ndarray) -> Place:
    if best is None:
        return _without_pattern(run, sums)
    fades = fading(run.motion, contribution) if best.dimension == "after_moves" else None
    text = best.text
    if fades is not None:
        text = f"{text[0]}; it fades with {fades:.2g} s", f"{text[1]}；时间常数 {fades:.2g} s"
    return Place(best.dimension, text, _holding(run, sums, best.rows))


def _without_pattern(run: Run, sums: Sums) -> Place:
    """In short stretches of the run that nothing else tells apart, or everywhere alike."""
    part = np.minimum(PARTS * np.arange(len(run.t)) // len(run.t), PARTS - 1)
    power = np.bincount(part, sums.second, PARTS)
    densest = np.argsort(-power)[: PARTS // 5]
    share = float(power[densest].sum() / power.sum())
    rows = np.isin(part, densest)
    if share < IN_STRETCHES:
        return Place("level", LEVEL, _holding(run, sums, np.ones(len(run.t), bool)))
    text = (
        f"{share:.0%} of it in a fifth of the time, in short stretches",
        (f"{share:.0%} 出现在仅占总时间五分之一的若干短时段内"),
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
