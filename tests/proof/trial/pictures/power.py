"""Power over visibility: in families of effects, and each effect with its own few cases."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tasks.rendering.chart import GREY, INK, PALE, draw
from tests.proof.plant.effects import CATALOGUE, FAMILIES
from tests.proof.trial.limit import power
from tests.proof.trial.pictures.outcome import LEGEND, LIMIT, RIGHT, WRONG, legend, outcome, squares
from tests.proof.trial.score import Score
from tests.proof.trial.table import Rate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 1000.0
LOWEST, HIGHEST = 2.0, 200.0  # z that is shown
TICKS = (3, 10, 30, 100)
SERIES = (("detected", INK), ("named right, or a pair with the truth", RIGHT),
          ("a wrong name", WRONG))  # fmt: skip
CALLED = {"timing": "time"}  # as the catalogue has it
KNOWS = "limit: knows the effect's form"
Z = "z: signal beside the noise"
Holds = Callable[[Score], object]
HOLDS: tuple[Holds, ...] = (
    lambda score: score.detected,
    lambda score: score.right_or_twin,
    lambda score: score.wrong_beyond_twins,
)


def alone(scores: Sequence[Score]) -> list[Score]:
    """The cases of one effect of the catalogue at a size asked for."""
    return [score for score in scores if score.kind in ("single", "faint") and score.asked_z]


def by_family(scores: Sequence[Score]) -> dict[str, list[Score]]:
    """Cases of one effect by the catalogue's families, in its order; without empty families."""
    families = {name: {effect.name for effect in effects} for name, effects in FAMILIES.items()}
    groups = {
        name: [score for score in scores if score.effects[0] in effects]
        for name, effects in families.items()
    }
    return {name: group for name, group in groups.items() if group}


def rates_by_z(scores: Sequence[Score], holds: Holds) -> list[tuple[float, Rate]]:
    """How many of the cases of each z asked it holds for."""
    groups: dict[float, list[Score]] = {}
    for score in scores:
        groups.setdefault(score.asked_z or 0.0, []).append(score)
    return [
        (z, Rate(sum(bool(holds(score)) for score in group), len(group)))
        for z, group in sorted(groups.items())
    ]


def limit_of(scores: Sequence[Score]) -> Callable[[float], float]:
    """The power of a detector that knows the form, in the mean over these cases."""
    counts = [next(iter(score.freedom.values())) for score in scores]
    shares = {k: counts.count(k) / len(counts) for k in set(counts)}
    return lambda z: sum(share * power(z, k) for k, share in shares.items())


def draw_power(
    axes: Any, limit: Sequence[Score], pooled: Sequence[Score], series: int = 3, size: float = 5.0
) -> None:
    """Shares over z: the limit of some cases, and the first `series` of HOLDS over others.

    Bars are 95 % intervals; what is beside others at the same z is shifted a little.
    """
    z = np.geomspace(LOWEST, HIGHEST, 61)
    if limit:
        axes.plot(z, [limit_of(limit)(at) for at in z], color=LIMIT, linewidth=1.6)
    for k, (holds, (_, colour)) in enumerate(zip(HOLDS[:series], SERIES, strict=False)):
        shown = [(at, r.share, r.interval) for at, r in rates_by_z(pooled, holds)
                 if r.share is not None and r.interval is not None]  # fmt: skip
        if shown:
            at, share, interval = (np.array(column) for column in zip(*shown, strict=True))
            bars = np.abs(interval.T - share)
            axes.errorbar(at * (1.0 + 0.08 * (k - 1)), share, bars, color=colour, fmt="-o",
                          markersize=size, linewidth=1.0, elinewidth=1.3)  # fmt: skip
    axes.set(xscale="log", xlim=(LOWEST, HIGHEST), ylim=(-0.03, 1.03))
    axes.set_xticks(TICKS, [f"{tick}" for tick in TICKS])
    axes.set_yticks([0.0, 0.5, 1.0], ["0 %", "50 %", "100 %"])
    axes.minorticks_off()
    axes.grid(axis="y", color=PALE)
    axes.set_axisbelow(True)
    axes.spines["left"].set_visible(False)
    axes.tick_params(length=0, labelcolor=GREY)


def _panels(figure: "Figure", count: int, columns: int) -> list[Any]:
    """Axes for so many panels, row by row; what is left over is not drawn."""
    rows = -(-count // columns) or 1
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for spare in axes[count:]:
        spare.set_axis_off()
    return axes[:count]


def families_svg(scores: Sequence[Score]) -> str:
    """A panel for each family: shares of its pooled cases with Wilson's intervals."""
    groups = by_family(alone(scores))

    def content(figure: "Figure") -> None:
        legend(figure, [*SERIES, (KNOWS, LIMIT)], loc="outside upper left")
        figure.supxlabel(Z, x=0.99, ha="right", fontsize=12, color=GREY)
        for axes, (name, group) in zip(
            _panels(figure, len(groups), 3), groups.items(), strict=True
        ):
            draw_power(axes, group, group)
            effects = len({score.effects[0] for score in group})
            title = f"{CALLED.get(name, name)}: effects {effects}, cases {len(group)}"
            axes.set_title(title, fontsize=12)

    return draw("Power by family", WIDTH, 80 + 200 * max(1, -(-len(groups) // 3)), content)


def effects_svg(scores: Sequence[Score]) -> str:
    """A small panel for each effect: the limit, its family's shares, and its own cases below."""
    separated = [s for s in scores if s.kind in ("single", "faint") and s.can_be_determined]
    shown = [
        (name, alone(group), own)
        for group in by_family(separated).values()
        for name in CATALOGUE
        if (own := [score for score in group if score.effects[0] == name])
    ]
    columns = 5

    def content(figure: "Figure") -> None:
        legend(figure, [(KNOWS, LIMIT), ("detected in its family", INK),
                        ("named right there", RIGHT)], loc="outside upper left")  # fmt: skip
        legend(figure, [(f"case: {words}", colour) for words, colour in LEGEND],
               loc="outside lower left")  # fmt: skip
        panels = _panels(figure, len(shown), columns)
        for n, (axes, (name, family, own)) in enumerate(zip(panels, shown, strict=True)):
            draw_power(axes, own, family, series=2, size=2.5)
            axes.set_title(name, fontsize=11)
            axes.tick_params(axis="x", pad=16, labelsize=10)
            axes.tick_params(axis="y", labelleft=n % columns == 0, labelsize=10)
            own = sorted(own, key=_visibility)
            squares(axes, _apart([_visibility(score) for score in own]), -0.16,
                    [outcome(score)[0] for score in own], 8)  # fmt: skip

    return draw("Power by effect", WIDTH, 80 + 140 * max(1, -(-len(shown) // columns)), content)


def _visibility(score: Score) -> float:
    return next(iter(score.z.values()))


def _apart(z: Sequence[float], ratio: float = 1.32) -> list[float]:
    """Sorted z as they are shown: within the panel, and each beside its neighbours."""
    placed: list[float] = []
    for at in z:
        placed.append(max(at, LOWEST, placed[-1] * ratio if placed else 0.0))
    rightmost = HIGHEST
    for n in reversed(range(len(placed))):
        placed[n] = min(placed[n], rightmost)
        rightmost = placed[n] / ratio
    return placed
