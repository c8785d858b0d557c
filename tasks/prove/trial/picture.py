"""The pictures of a trial: detection and names over z, and every case of every effect."""

from collections.abc import Sequence
from math import log10

from scipy.stats import norm

from tasks.explain.report.svg import GREY, INK, label, line, path, picture, rect, width_of
from tasks.explain.search import FALSE_ALARMS
from tasks.prove.trial.score import Score
from tasks.prove.trial.table import Rate, row

RIGHT, TWIN, ABSTAINED, WRONG, MISSED = "#0072b2", "#56b4e9", "#bbbbbb", "#d55e00", "#ffffff"
LIMIT = "#009e73"
WIDTH, LEFT, END, TOP, PLOT = 900, 70, 870, 66, 320
LOWEST, HIGHEST = 1.0, 200.0  # z of the picture
APART = 7.0  # between the marks of one z
CELL, LINE, NAMES = 14.0, 20.0, 250.0


def power_svg(scores: Sequence[Score]) -> str:
    """Share detected, rightly and wrongly named over the z asked, beside the limit of a detector
    that knows the form: Φ(z − z_α)."""
    sized = [each for each in scores if each.kind in ("single", "faint") and each.asked_z]
    limit_z = float(norm.isf(FALSE_ALARMS))
    course = [LOWEST * (HIGHEST / LOWEST) ** (i / 200) for i in range(201)]
    parts = [
        *_frame(),
        path([(_x(z), _y(float(norm.cdf(z - limit_z)))) for z in course], LIMIT, 2.0),
    ]
    series = (("detected", INK), ("first name right", RIGHT), ("any name wrong", WRONG))
    ends: list[list[tuple[float, float]]] = [[], [], []]
    for z in sorted({each.asked_z for each in sized if each.asked_z}):
        figures = row("", z, [each for each in sized if each.asked_z == z])
        for k, rate in enumerate((figures.detected, figures.right, figures.wrong)):
            x = _x(z) + APART * (k - 1)
            parts += _mark(x, rate, series[k][1])
            ends[k].append((x, _y(rate.share or 0.0)))
    parts += [path(points, colour, 1.2) for points, (_, colour) in zip(ends, series, strict=True)]
    legend = [*series, (f"limit: the form is known, {100 * FALSE_ALARMS:g} % false alarms", LIMIT)]
    return picture(WIDTH, TOP + PLOT + 50, "Detection and names over visibility",
                   parts + _legend(legend, 22.0))  # fmt: skip


def _frame() -> list[str]:
    parts = []
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        parts.append(line(LEFT, _y(share), END, _y(share), "#e4e4e4"))
        parts.append(label(LEFT - 8, _y(share) + 4, f"{100 * share:.0f} %", 12, "end"))
    for z in (1, 3, 5, 10, 30, 100):
        parts.append(line(_x(z), TOP + PLOT, _x(z), TOP + PLOT + 5, INK))
        parts.append(label(_x(z), TOP + PLOT + 20, f"{z}", 12, "middle"))
    parts.append(line(LEFT, TOP + PLOT, END, TOP + PLOT, INK))
    parts.append(label(END, TOP + PLOT + 38, "z: signal beside the noise", 12, "end", GREY))
    return parts


def _mark(x: float, rate: Rate, colour: str) -> list[str]:
    if rate.interval is None or rate.share is None:
        return []
    low, high = rate.interval
    y = _y(rate.share)
    return [
        line(x, _y(low), x, _y(high), colour, 1.6),
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>',
    ]


def _x(z: float) -> float:
    return LEFT + log10(z / LOWEST) / log10(HIGHEST / LOWEST) * (END - LEFT)


def _y(share: float) -> float:
    return TOP + PLOT * (1.0 - share)


def _legend(entries: Sequence[tuple[str, str]], y: float) -> list[str]:
    parts, at = [], float(LEFT)
    for words, colour in entries:
        parts += [_square(at, y - 10, colour), label(at + CELL + 5, y + 1, words)]
        at += CELL + 24 + width_of(words)
    return parts


def _square(x: float, y: float, colour: str) -> str:
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{CELL - 2:g}" height="{CELL - 2:g}" '
        f'fill="{colour}" stroke="{GREY}" stroke-width="0.6"/>'
    )


def outcome(score: Score) -> tuple[str, str]:
    """The colour of a case, and what it means: the worst that can be said of it first."""
    if score.wrong_beyond_twins:
        return WRONG, "a wrong name"
    if score.right:
        return RIGHT, "first name right"
    if not score.has_a_name and (score.abstained or not score.can_be_told):
        return RIGHT, "rightly without a name"
    if score.right_or_twin:
        return TWIN, "a twin named, the truth listed beside it"
    if score.abstained:
        return ABSTAINED, "found, left unnamed"
    return MISSED, "nothing found"


def cases_svg(scores: Sequence[Score]) -> str:
    """A square for each case: effects by row, z by column."""
    kept = [each for each in scores if len(each.effects) == 1]
    names = sorted({each.effects[0] for each in kept}, key=lambda n: (n.startswith("x_"), n))
    columns = [*sorted({each.asked_z for each in kept if each.asked_z}), None]
    most = {
        z: max(sum(e.asked_z == z and e.effects[0] == name for e in kept) for name in names)
        for z in columns
    } if names else {}  # fmt: skip
    parts, at = [], NAMES
    places: dict[float | None, float] = {}
    for z in columns:
        if most.get(z):
            places[z] = at
            parts.append(label(at, 54, "as it is" if z is None else f"z {z:g}", 13, bold=True))
            at += max(CELL * most[z], 64.0) + 14.0
    for n, name in enumerate(names):
        y = 64.0 + LINE * n
        parts.append(label(0, y + CELL - 3, name))
        parts.append(rect(0, y + LINE - 4, at, 0.5, "#e4e4e4"))
        for z, x in places.items():
            same = [e for e in kept if e.effects[0] == name and e.asked_z == z]
            parts += [_square(x + CELL * k, y, outcome(e)[0]) for k, e in enumerate(same)]
    legend = [
        ("right", RIGHT), ("a twin, the truth beside it", TWIN),
        ("left unnamed", ABSTAINED), ("nothing found", MISSED), ("a wrong name", WRONG),
    ]  # fmt: skip
    shown = [*_legend(legend, 22.0), *parts]
    return picture(max(at, WIDTH), 76.0 + LINE * len(names), "Every case", shown)
