"""What became of a case, as a colour and in words."""

from collections.abc import Sequence

from tasks.explain.report.svg import GREY, label, width_of
from tests.proof.trial.score import Score

RIGHT, TWIN, ABSTAINED, MISSED, WRONG = "#0072b2", "#56b4e9", "#bbbbbb", "#ffffff", "#d55e00"
LIMIT = "#009e73"
SIDE = 12.0  # of a square
LEGEND = (
    ("right", RIGHT), ("a pair with the truth in it", TWIN), ("left unnamed", ABSTAINED),
    ("nothing found", MISSED), ("a wrong name", WRONG),
)  # fmt: skip


def outcome(score: Score) -> tuple[str, str]:
    """The colour of a case, and what it means: the worst that can be said of it first."""
    if score.wrong_beyond_twins:
        return WRONG, "a wrong name"
    if score.right:
        return RIGHT, "first name right"
    if not score.has_a_name and (score.abstained or not score.can_be_told):
        return RIGHT, "rightly without a name"
    if score.right_or_twin:
        return TWIN, "a pair with the truth in it"
    if score.abstained:
        return ABSTAINED, "found, left unnamed"
    return MISSED, "nothing found"


def square(x: float, y: float, colour: str, side: float = SIDE) -> str:
    """The mark of a case; x and y are its upper left corner."""
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{side:g}" height="{side:g}" '
        f'fill="{colour}" stroke="{GREY}" stroke-width="0.6"/>'
    )


def legend(entries: Sequence[tuple[str, str]], x: float, y: float, size: float = 13) -> list[str]:
    """Coloured squares with their words, in one line; y is its base line."""
    parts, at = [], x
    for words, colour in entries:
        parts += [square(at, y - 10.5, colour), label(at + SIDE + 6, y, words, size)]
        at += SIDE + 18 + 0.92 * width_of(words, size)
    return parts
