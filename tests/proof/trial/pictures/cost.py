"""How wrong the certificate is without the physics, and with it found: a dumbbell per effect."""

from collections.abc import Sequence
from math import log10
from statistics import median

from tasks.explain.report.svg import AFTER, BEFORE, GREY, INK, PALE, label, line, picture
from tests.proof.trial.cost import Cost
from tests.proof.trial.pictures.outcome import legend
from tests.proof.trial.score import Score
from tests.proof.trial.table import by_effect

WIDTH, NAMES, END, LINE, TOP = 900.0, 230.0, 800.0, 19.0, 62.0
LOWEST, HIGHEST = 0.01, 1000.0  # U; what is beyond is drawn at the end


def costs_by_effect(scores: Sequence[Score]) -> dict[str, list[Cost]]:
    """The costs of each effect alone, in the order of the table."""
    costs = {
        each.name: [e.cost for e in scores if e.effects == (each.name,) and e.cost is not None]
        for each in by_effect(scores)
    }
    return {name: some for name, some in costs.items() if some}


def cost_svg(scores: Sequence[Score]) -> str:
    """The median largest error in U before and after, each case as a tick, on a log axis."""
    groups = costs_by_effect(scores)
    foot = TOP + LINE * len(groups) + 4
    entries = [("as the clauses give it", BEFORE), ("with what was found taken off", AFTER)]
    parts = legend(entries, NAMES, 18)
    parts.append(label(END, foot + 16, "dots: medians; ticks: single recordings", 12, "end", GREY))
    for power in range(-2, 4):
        x = _x(10.0**power)
        one = power == 0
        parts.append(line(x, TOP - 14, x, foot, INK if one else PALE, 1.2 if one else 1.0))
        words = "stated U" if one else f"{10.0**power:g} U"
        parts.append(label(x, TOP - 20, words, 12, "middle", INK if one else GREY, bold=one))
    for n, (name, costs) in enumerate(groups.items()):
        y = TOP + LINE * n
        parts += [label(NAMES - 12, y + 4, name, 12.5, "end"), *_dumbbell(y, costs)]
    return picture(WIDTH, foot + 24, "Error of the certificate, before and after", parts)


def _dumbbell(y: float, costs: Sequence[Cost]) -> list[str]:
    before, after = (_x(median(values)) for values in (
        [cost.before for cost in costs], [cost.after for cost in costs]
    ))  # fmt: skip
    parts = [line(before, y, after, y, "#b0b0b0", 3.0)]
    for cost in costs:
        parts.append(line(_x(cost.before), y - 6, _x(cost.before), y - 1, BEFORE, 1.0))
        parts.append(line(_x(cost.after), y + 1, _x(cost.after), y + 6, AFTER, 1.0))
    for x, colour in ((before, BEFORE), (after, AFTER)):
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}"/>')
    return parts


def _x(ratio: float) -> float:
    place = log10(min(max(ratio, LOWEST), HIGHEST) / LOWEST) / log10(HIGHEST / LOWEST)
    return NAMES + place * (END - NAMES)
