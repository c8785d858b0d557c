"""A square for every case: which effects are named, and from which visibility on."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tasks.rendering.chart import PALE, draw
from tests.proof.trial.pictures.outcome import LEGEND, legend, outcome, squares
from tests.proof.trial.score import Score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAP = 1.5  # squares between columns
NARROWEST = 4  # squares of a column


def cases_svg(scores: Sequence[Score]) -> str:
    """A square for each case: effects by row, z by column."""
    kept = [score for score in scores if len(score.effects) == 1]
    names = sorted({score.effects[0] for score in kept}, key=lambda n: (n.startswith("x_"), n))
    groups: dict[float | None, dict[str, list[Score]]] = {}
    for z in [*sorted({score.asked_z for score in kept if score.asked_z}), None]:
        same = {name: [s for s in kept if s.effects[0] == name and s.asked_z == z]
                for name in names}  # fmt: skip
        if any(same.values()):
            groups[z] = same

    def content(figure: "Figure") -> None:
        legend(figure, LEGEND, loc="outside upper left")
        axes = figure.subplots()
        start = 0.0
        for z, same in groups.items():
            title = "as it is" if z is None else f"z {z:g}"
            axes.text(start - 0.4, -0.9, title, weight="bold", va="bottom")
            for row, cases in enumerate(same.values()):
                squares(axes, [start + k for k in range(len(cases))], row,
                        [outcome(score)[0] for score in cases], 12)  # fmt: skip
            start += max(NARROWEST, *map(len, same.values())) + GAP
        axes.set(xlim=(-1, max(start, 44.0)), ylim=(len(names) - 0.4, -1.6), xticks=[])
        axes.set_yticks(range(len(names)), names)
        axes.hlines([row + 0.5 for row in range(len(names))], -1, start, color=PALE, linewidth=0.5)
        axes.spines[["left", "bottom"]].set_visible(False)
        axes.tick_params(length=0)

    return draw("Every case", 900, 130 + 20 * len(names), content)
