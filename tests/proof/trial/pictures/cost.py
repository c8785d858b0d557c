"""How wrong the certificate is without the physics, and with it found: a dumbbell per effect."""

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from tasks.rendering.chart import AFTER, BEFORE, INK, PALE, draw
from tests.proof.trial.cost import Cost
from tests.proof.trial.pictures.outcome import legend
from tests.proof.trial.score import Score
from tests.proof.trial.table import by_effect

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOWEST, HIGHEST = 0.01, 1000.0  # U; what is beyond is drawn at the end
ENTRIES = (("as the clauses give it", BEFORE), ("with what was found taken off", AFTER))


def costs_by_effect(scores: Sequence[Score]) -> dict[str, list[Cost]]:
    """The costs of each effect alone, in the order of the table."""
    costs = {
        row.name: [s.cost for s in scores if s.effects == (row.name,) and s.cost is not None]
        for row in by_effect(scores)
    }
    return {name: some for name, some in costs.items() if some}


def cost_svg(scores: Sequence[Score]) -> str:
    """The median largest error in U before and after, each case as a tick, on a log axis."""
    groups = costs_by_effect(scores)

    def content(figure: "Figure") -> None:
        legend(figure, ENTRIES, loc="outside upper left")
        axes = figure.subplots()
        for place, costs in enumerate(groups.values()):
            _draw_dumbbell(axes, place, costs)
        axes.set(xscale="log", xlim=(LOWEST, HIGHEST), ylim=(max(len(groups), 1) - 0.4, -0.6))
        axes.set_yticks(range(len(groups)), groups)
        powers = 10.0 ** np.arange(-2, 4)
        axes.set_xticks(powers, ["stated U" if p == 1 else f"{p:g} U" for p in powers])
        axes.minorticks_off()
        axes.tick_params(length=0, labeltop=True, labelbottom=False)
        axes.grid(axis="x", color=PALE)
        axes.set_axisbelow(True)
        axes.axvline(1.0, color=INK, linewidth=1.2)
        axes.spines[["left", "bottom"]].set_visible(False)
        axes.set_xlabel("dots: medians; ticks: single recordings", loc="right")

    height = 120 + 20 * len(groups)
    return draw("Error of the certificate, before and after", 900, height, content)


def _draw_dumbbell(axes: Any, place: int, costs: Sequence[Cost]) -> None:
    before, after = (np.clip(values, LOWEST, HIGHEST) for values in (
        [cost.before for cost in costs], [cost.after for cost in costs]
    ))  # fmt: skip
    axes.vlines(before, place - 0.35, place - 0.08, color=BEFORE, linewidth=1.0)
    axes.vlines(after, place + 0.08, place + 0.35, color=AFTER, linewidth=1.0)
    axes.plot([median(before), median(after)], [place, place], color="#b0b0b0", linewidth=3.0)
    axes.scatter([median(before), median(after)], [place, place], c=[BEFORE, AFTER], s=70, zorder=3)
