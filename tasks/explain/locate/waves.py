"""Excess that goes in waves with the turns of the table, or at one frequency."""

import numpy as np

from tasks.explain.locate.patterns import Pattern, Seen, followed, gathered, paid
from tasks.explain.locate.run import Run
from tasks.explain.locate.turns import HIGHEST, Turns

TOGETHER = 3  # numbers of waves that are told together
OF_THE_FIRST = 0.2  # power of the next from which it is told beside it
PERIODS = 8  # in the run: slower is a trend
WIDTH, BESIDE = 0.005, 2  # of the frequency, and lines beside it, that belong to it


def by_turns(run: Run, turns: Turns, seen: Seen) -> Pattern:
    """The numbers of waves per turn of an axis that hold most of an excess."""
    course = seen.course
    waves = turns.waves(course)
    order = np.argsort(-waves)[:TOGETHER]
    whole = seen.power
    turning = float((course[turns.rows] ** 2).sum())
    kept = order[waves[order] >= OF_THE_FIRST * waves[order[0]]]
    held = min(float(waves[kept].sum()), turning)
    rows = np.array([len(turns.rows), len(course) - len(turns.rows)], float)
    left = np.array([turning - held, whole - turning])
    cost = paid(2 * len(kept), HIGHEST, run.pieces)
    score = gathered(rows, left, whole) - cost
    numbers = [str(each) for each in sorted(kept + 1)]
    counted = "one wave" if numbers == ["1"] else f"{' and '.join(numbers)} waves"
    mask = np.zeros(len(course), bool)
    mask[turns.rows] = True
    text = (
        f"{held / whole:.0%} of it is {counted} per turn of the {turns.name} axis",
        f"{held / whole:.0%} 为 {turns.name} 轴每转 {'、'.join(numbers)} 个周期的波",
    )
    return Pattern("rotation_phase", score, text, mask[run.starts])


def by_frequency(run: Run, seen: Seen) -> Pattern | None:
    """The frequency at which an excess has most of its power."""
    course, count = seen.course, len(seen.course)
    power = np.abs(np.fft.rfft(course)) ** 2
    if len(power) < 2 * PERIODS or count < 2:
        return None
    power[1 : (count + 1) // 2] *= 2
    lines = np.arange(PERIODS, len(power))
    reach = BESIDE + (WIDTH * lines).astype(int)
    summed = np.concatenate([[0.0], np.cumsum(power)])
    held = summed[np.minimum(lines + reach + 1, len(power))] - summed[lines - reach]
    most = int(held.argmax())
    share = float(held[most] / power.sum())
    band = slice(lines[most] - reach[most], lines[most] + reach[most] + 1)
    line = band.start + int(power[band].argmax())
    around = np.arange(line - 1, min(line + 2, len(power)))
    hertz = float(around @ power[around] / power[around].sum()) / (count * run.motion.interval)
    score = followed(share) - paid(2, len(lines), run.pieces)
    text = f"{share:.0%} of it at {hertz:.4g} Hz", f"{share:.0%} 集中在 {hertz:.4g} Hz"
    return Pattern("frequency", score, text, np.ones(len(run.t), bool))
