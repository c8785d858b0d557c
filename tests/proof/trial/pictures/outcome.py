"""What became of a case, as a colour and in words."""

from collections.abc import Iterable
from typing import Any

from tasks.rendering.chart import GREY
from tests.proof.trial.score import Score

RIGHT, TWIN, ABSTAINED, MISSED, WRONG = "#0072b2", "#56b4e9", "#bbbbbb", "#ffffff", "#d55e00"
LIMIT = "#009e73"
LEGEND = (
    ("right", RIGHT), ("a pair with the truth in it", TWIN), ("left unnamed", ABSTAINED),
    ("nothing found", MISSED), ("a wrong name", WRONG),
)  # fmt: skip
OUTLINE: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.6}


def outcome(score: Score) -> tuple[str, str]:
    """The colour of a case, and what it means: the worst that can be said of it first."""
    if score.wrong_beyond_twins:
        return WRONG, "a wrong name"
    if score.right:
        return RIGHT, "first name right"
    if not score.has_a_name and (score.abstained or not score.can_be_determined):
        return RIGHT, "rightly without a name"
    if score.right_or_twin:
        return TWIN, "a pair with the truth in it"
    if score.abstained:
        return ABSTAINED, "found, left unnamed"
    return MISSED, "nothing found"


def squares(axes: Any, x: Iterable[float], y: float, colours: list[str], size: float) -> None:
    """The marks of cases in a row; `size` is a side in px."""
    x = list(x)
    axes.scatter(x, [y] * len(x), c=colours, marker="s", s=size**2, clip_on=False, **OUTLINE)


def legend(figure: Any, entries: Iterable[tuple[str, str]], **where: Any) -> None:
    """Coloured squares with their words, in one line."""
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=colour, label=words, **OUTLINE) for words, colour in entries]
    figure.legend(handles=handles, ncols=len(handles), handlelength=1.0, handleheight=1.0,
                  columnspacing=1.2, handletextpad=0.5, **where)  # fmt: skip
