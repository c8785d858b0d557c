"""A square for every case: which effects are named, and from which visibility on."""

from collections.abc import Sequence

from tasks.explain.report.svg import label, picture, rect
from tests.proof.trial.pictures.outcome import LEGEND, legend, outcome, square
from tests.proof.trial.score import Score

WIDTH, CELL, LINE, NAMES = 900.0, 14.0, 20.0, 250.0


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
            parts += [square(x + CELL * k, y, outcome(e)[0]) for k, e in enumerate(same)]
    shown = [*legend(LEGEND, 0.0, 22.0), *parts]
    return picture(max(at, WIDTH), 76.0 + LINE * len(names), "Every case", shown)
