"""The one picture for a reader in a hurry: who is named, beside the limit; and how well hidden."""

from collections.abc import Sequence

from tasks.explain.report.svg import GREY, INK, label, line, picture, rect
from tests.proof.trial.pictures.outcome import LEGEND, LIMIT, MISSED, RIGHT, WRONG, legend, outcome
from tests.proof.trial.pictures.panel import Panel
from tests.proof.trial.pictures.power import HOLDS, KNOWS, alone, limit_of, rates_by_z
from tests.proof.trial.score import Score

WIDTH, HEIGHT, TOP, TALL = 1000.0, 400.0, 92.0, 240.0
LEFT = Panel(62.0, TOP, 420.0, TALL)
RIGHT_X, BAR, BINS = 590.0, 38.0, 10


def headline_svg(scores: Sequence[Score]) -> str:
    """Left: shares detected, named and wrongly named over z. Right: cases by concealment."""
    kept = alone(scores)
    return picture(
        WIDTH, HEIGHT, "Naming over visibility, and what the standard hides",
        [*_naming(kept), *_hiding(kept)],
    )  # fmt: skip


def _naming(kept: Sequence[Score]) -> list[str]:
    said = (("detected", INK), ("named right*", RIGHT), ("a wrong name", WRONG))
    parts = [
        label(LEFT.left, 26, "One effect alone: is it named?", 16, bold=True),
        *legend([*said, (KNOWS, LIMIT)], LEFT.left, 54, 12),
        *LEFT.frame(12),
        *LEFT.numbers(TOP + TALL + 18, 12),
        label(LEFT.left + LEFT.width, TOP + TALL + 36, "z: signal beside the noise, after the "
              "standard's parameters took their part", 12, "end", GREY),
        label(LEFT.left + LEFT.width, TOP + TALL + 54, "* or a pair that holds the truth; bars: "
              "95 % intervals", 12, "end", GREY),
    ]  # fmt: skip
    if kept:
        parts.append(LEFT.curve(limit_of(kept), LIMIT, 2.2))
    for k, (holds, (_, colour)) in enumerate(zip(HOLDS, said, strict=True)):
        parts += LEFT.series(rates_by_z(kept, holds), colour, 7.0 * (k - 1), 4.0)
    return parts


def _hiding(kept: Sequence[Score]) -> list[str]:
    bins: list[list[str]] = [[] for _ in range(BINS)]
    for each in kept:
        share = each.concealment[each.effects[0]]
        bins[min(int(share * BINS), BINS - 1)].append(outcome(each)[0])
    most = max((len(one) for one in bins), default=0) or 1
    foot = TOP + TALL
    parts = [
        label(RIGHT_X, 26, "How much of it do the standard's parameters hide?", 16, bold=True),
        *legend([(short, colour) for short, (_, colour) in zip(
            ("right", "pair", "unnamed", "missed", "wrong"), LEGEND, strict=True)],
            RIGHT_X, 54, 12),
        line(RIGHT_X, foot, RIGHT_X + BAR * BINS, foot, GREY),
        label(RIGHT_X + BAR * BINS, foot + 36, "share of the effect's power that they absorb", 12,
              "end", GREY),
        label(RIGHT_X + BAR * BINS, foot + 54, "height: recordings", 12, "end", GREY),
    ]  # fmt: skip
    for n, one in enumerate(bins):
        parts += _bar(RIGHT_X + BAR * n, foot, one, TALL / most)
    for n in range(0, BINS + 1, 2):
        x = RIGHT_X + BAR * n
        parts.append(label(x, foot + 18, f"{100 * n // BINS} %", 12, "middle", GREY))
    return parts


def _bar(x: float, foot: float, colours: Sequence[str], each: float) -> list[str]:
    """Stacked by outcome, with the count on top."""
    parts, y = [], foot
    for _, colour in LEGEND:
        tall = each * colours.count(colour)
        if tall:
            y -= tall
            parts.append(rect(x + 3, y, BAR - 6, tall, colour))
            if colour == MISSED:
                parts.append(_outline(x + 3, y, BAR - 6, tall))
    if colours:
        parts.append(label(x + BAR / 2, y - 5, f"{len(colours)}", 12, "middle"))
    return parts


def _outline(x: float, y: float, w: float, h: float) -> str:
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" fill="none" '
        f'stroke="{GREY}" stroke-width="0.6"/>'
    )
