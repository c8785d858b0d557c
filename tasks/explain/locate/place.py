"""The one way of saying where an excess sits that tells most."""

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from schemas.discrepancy import Dimension
from tasks.explain.locate.fading import fading
from tasks.explain.locate.patterns import Pattern, View, by_cut, by_regime
from tasks.explain.locate.run import Run, Sums
from tasks.explain.locate.waves import by_frequency, by_turns
from tasks.model.term import Text

OF_THE_EXCESS = 0.1  # of its mean square: smaller remainders do not count
OF_THE_SHAPE = 0.01  # the same of the whole contribution, which nothing blurs
NEARLY = 0.75  # of what the best tells
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


def patterns_in(run: Run, course: np.ndarray, view: View) -> list[Pattern]:
    """Every way of saying where one channel's course (n,) sits, in the same order for all."""
    sums = run.sums(course)
    tried = Counter(regime.dimension for regime in run.regimes)
    every = [by_regime(run, each, sums, view, tried[each.dimension]) for each in run.regimes]
    every += [by_turns(run, turns, course, sums, view.floor) for turns in run.turns]
    more = (by_cut(run, sums, view), by_frequency(run, course, sums, view.floor))
    return every + [each for each in more if each is not None]


def places(
    run: Run,
    excess: Mapping[int, np.ndarray],
    whole: Mapping[int, np.ndarray],
    noise: np.ndarray,
) -> dict[int, Place]:
    """The place of each channel's part of one finding.

    excess, whole: channel -> (n,) what the standard's model leaves of the contribution and the
    contribution about its mean, in standard deviations of the noise (6,).
    A pattern counts by what it tells of the channel's excess, and its dimension by what it tells
    in all channels, for one physics is seen in all of them. Among those that tell nearly as
    much as the best, the whole contribution decides: the standard's model does not blur it.
    """
    views = {channel: _view(channel, float(noise[channel])) for channel in excess}
    found = {c: patterns_in(run, course, views[c]) for c, course in excess.items()}
    power = {c: float((course**2).sum()) for c, course in excess.items()}
    votes: defaultdict[Dimension, float] = defaultdict(float)
    for channel, ways in found.items():
        best = {way.dimension: way.score for way in sorted(ways, key=lambda each: each.score)}
        for dimension, score in best.items():
            votes[dimension] += power[channel] / sum(power.values()) * score
    placed = {}
    for channel, ways in found.items():
        shapes = patterns_in(run, whole[channel], replace(views[channel], floor=OF_THE_SHAPE))
        chosen = _most_telling(ways, shapes, votes)
        placed[channel] = _place(run, chosen, run.sums(excess[channel]), whole[channel])
    return placed


def _most_telling(
    ways: list[Pattern], shapes: list[Pattern], votes: Mapping[Dimension, float]
) -> Pattern | None:
    """The way that tells most of the excess, or None; shapes: the same of the contribution."""
    totals = {
        k: way.score + votes[way.dimension] for k, way in enumerate(ways) if way.score >= TELLING
    }
    most = max(totals.values(), default=0.0)
    near = {k: total + shapes[k].score for k, total in totals.items() if total >= NEARLY * most}
    return ways[max(near, key=lambda k: near[k])] if near else None


def _view(channel: int, noise: float) -> View:
    """noise: one standard deviation, rad/s or m/s², what the excess is counted in."""
    if channel < 3:
        return View(OF_THE_EXCESS, float(np.degrees(noise)), "°/s")
    return View(OF_THE_EXCESS, noise, "m/s²")


def _place(run: Run, best: Pattern | None, sums: Sums, whole: np.ndarray) -> Place:
    if best is None:
        return _without_pattern(run, sums)
    fades = fading(run.motion, whole) if best.dimension == "after_moves" else None
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
