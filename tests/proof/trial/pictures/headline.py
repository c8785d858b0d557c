"""The one picture for a reader in a hurry: who is named, beside the limit; and how well hidden."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tasks.rendering.chart import GREY, INK, draw
from tests.proof.trial.pictures.outcome import (
    LEGEND,
    LIMIT,
    MISSED,
    OUTLINE,
    RIGHT,
    WRONG,
    legend,
    outcome,
)
from tests.proof.trial.pictures.power import KNOWS, alone, draw_power
from tests.proof.trial.score import Score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BINS = 10
Z = "z: signal beside the noise, after the standard's parameters took their part"
BARS = "* or a pair that holds the truth; bars: 95 % intervals"
SHORT = ("right", "pair", "unnamed", "missed", "wrong")


def headline_svg(scores: Sequence[Score]) -> str:
    """Left: shares detected, named and wrongly named over z. Right: cases by concealment."""
    kept = alone(scores)

    def content(figure: "Figure") -> None:
        naming, hiding = figure.subplots(1, 2)
        series = (("detected", INK), ("named right*", RIGHT), ("a wrong name", WRONG))
        naming.set_title("One effect alone: is it named?", **TITLE)
        legend(naming, [*series, (KNOWS, LIMIT)], **BELOW_TITLE)
        draw_power(naming, kept, kept)
        naming.set_xlabel(Z, loc="right")
        naming.annotate(BARS, (1, 0), xytext=(0, -44), xycoords="axes fraction", color=GREY,
                        textcoords="offset points", ha="right")  # fmt: skip
        hiding.set_title("How much of it do the standard's parameters hide?", **TITLE)
        entries = zip(SHORT, (colour for _, colour in LEGEND), strict=True)
        legend(hiding, entries, **BELOW_TITLE)
        _draw_hiding(hiding, kept)

    return draw("Naming over visibility, and what the standard hides", 1040, 430, content)


TITLE: dict[str, Any] = {"fontsize": 15, "pad": 38}
BELOW_TITLE: dict[str, Any] = {
    "loc": "lower left", "bbox_to_anchor": (0, 1.03), "borderpad": 0, "borderaxespad": 0,
    "fontsize": 11,
}  # fmt: skip


def _draw_hiding(axes: Any, kept: Sequence[Score]) -> None:
    """Recordings by the share that is hidden, stacked by outcome, with the count on top."""
    shares = np.array([score.concealment[score.effects[0]] for score in kept])
    bins = np.minimum((shares * BINS).astype(int), BINS - 1)
    colours = np.array([outcome(score)[0] for score in kept])
    foot = np.zeros(BINS)
    middles = (np.arange(BINS) + 0.5) / BINS
    for _, colour in LEGEND:
        counts = np.bincount(bins[colours == colour], minlength=BINS) if len(kept) else foot * 0
        edge = OUTLINE if colour == MISSED else {}
        axes.bar(middles, counts, 0.85 / BINS, foot, color=colour, **edge)
        foot = foot + counts
    for x, height in zip(middles, foot, strict=True):
        if height:
            axes.annotate(f"{height:.0f}", (x, height), xytext=(0, 3), ha="center",
                          textcoords="offset points")  # fmt: skip
    axes.set(xlim=(0, 1), ylim=(0, 1.1 * (foot.max() or 1)), yticks=[])
    axes.spines["left"].set_visible(False)
    axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.set_xlabel("share of the effect's power that they absorb; height: recordings", loc="right")
