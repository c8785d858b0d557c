"""Where a finding's excess sits: channel, regime and segments, never «somewhere».

The excess of a finding is what the standard's model cannot take up of its contribution. Each
channel's part of it is held against every way of parting the run (by rate, by attitude, by
temperature …); the way under which least is left unsaid is where it sits.
"""

import numpy as np

from schemas.discrepancy import Statement, Where
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.explain.locate.excess import Columns, excess_of, scales
from tasks.explain.locate.map import ExcessMap, excess_map
from tasks.explain.locate.patterns import Seen
from tasks.explain.locate.place import Place, places
from tasks.explain.locate.run import Run

TOUCHED = 0.05  # share of a finding's excess from which a channel has an entry of its own
NOTHING = 1e-4  # share of the other channels together that is not worth an entry
INVISIBLE = 1e-6  # square sum, in variances of the noise, that is arithmetic
NOWHERE = Place(
    "level",
    ("where the motion is known, the standard's model takes it up whole",
     "在运动已知处，已被规范模型全部吸收"),
    (),
)  # fmt: skip
SLIGHT = Place("level", ("less than 5 % of it in each", "各占不足 5 %"), ())

__all__ = ["ExcessMap", "excess_map", "locate"]


def locate(explanation: Explanation) -> tuple[tuple[Where, ...], ...]:
    """For each finding where its excess sits, by falling share; the shares add up to 1.

    A channel with 5 % or more of the excess has one entry, its share that of the channel. What
    the others hold is a last entry of dimension «level», their names separated by commas. A
    finding that is seen nowhere has one entry, «level», at its first channel.
    """
    if not explanation.findings:
        return ()
    run = Run.of(explanation.recording)
    columns = tuple(Columns.of(run.motion, channel) for channel in range(6))
    noise = scales(explanation.noise)
    strengths = excess_of(explanation, columns)
    return tuple(
        _entries(run, finding, strength, columns, noise)
        for finding, strength in zip(explanation.findings, strengths, strict=True)
    )


def _entries(
    run: Run,
    finding: Finding,
    strength: np.ndarray,
    columns: tuple[Columns, ...],
    noise: np.ndarray,
) -> tuple[Where, ...]:
    """strength: (n, 6) excess in standard deviations of the noise (6,)."""
    power = (strength**2).sum(axis=0)
    if power.sum() < INVISIBLE:
        return (_where(CHANNELS[(*finding.channels, 0)[0]], NOWHERE, 1.0),)
    share = power / power.sum()
    touched = [int(c) for c in np.argsort(-share) if share[c] >= TOUCHED]
    channels = {c: _seen(run, strength[:, c], columns[c], c, float(noise[c])) for c in touched}
    placed = places(run, channels, finding.contribution)
    entries = [_where(CHANNELS[c], placed[c], float(share[c])) for c in touched]
    rest = 1.0 - sum(each.share for each in entries)
    if rest > NOTHING:
        slight = ", ".join(CHANNELS[c] for c in range(6) if 0 < share[c] < TOUCHED)
        return (*entries, _where(slight, SLIGHT, rest))
    first = entries[0].model_copy(update={"share": entries[0].share + rest})
    return (first, *entries[1:])


def _seen(run: Run, course: np.ndarray, columns: Columns, channel: int, noise: float) -> Seen:
    """noise: one standard deviation, rad/s or m/s², in which the course (n,) is counted."""
    factor, unit = (float(np.degrees(noise)), "°/s") if channel < 3 else (noise, "m/s²")
    sums = run.sums(course, columns.known)
    return Seen(course, sums, columns, run.summed(columns.values), factor, unit)


def _where(channel: str, place: Place, share: float) -> Where:
    en, zh = place.description
    return Where(
        channel=channel, dimension=place.dimension, description=Statement(en=en, zh=zh),
        segments=place.segments, share=share,
    )  # fmt: skip
