"""What became of a case, as a colour and in words."""

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from tasks.rendering.chart import AFTER, BEFORE, GREY, INK, PALE, draw
from tests.proof.plant.effects import CATALOGUE, FAMILIES
from tests.proof.trial.parameters import power
from tests.proof.trial.score import Cost, Rate, Score, by_effect

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


# A square for every case: which effects are named, and from which visibility on.

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


# How wrong the certificate is without the physics, and with it found: a dumbbell per effect.

LEAST_U, MOST_U = 0.01, 1000.0  # U; what is beyond is drawn at the end
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
        axes.set(xscale="log", xlim=(LEAST_U, MOST_U), ylim=(max(len(groups), 1) - 0.4, -0.6))
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
    before, after = (np.clip(values, LEAST_U, MOST_U) for values in (
        [cost.before for cost in costs], [cost.after for cost in costs]
    ))  # fmt: skip
    axes.vlines(before, place - 0.35, place - 0.08, color=BEFORE, linewidth=1.0)
    axes.vlines(after, place + 0.08, place + 0.35, color=AFTER, linewidth=1.0)
    axes.plot([median(before), median(after)], [place, place], color="#b0b0b0", linewidth=3.0)
    axes.scatter([median(before), median(after)], [place, place], c=[BEFORE, AFTER], s=70, zorder=3)


# Power over visibility: in families of effects, and each effect with its own few cases.

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


# The one picture for a reader in a hurry: who is named, beside the limit; and how well hidden.

BINS = 10
Z_OF_ALL = "z: signal beside the noise, after the standard's parameters took their part"
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
        naming.set_xlabel(Z_OF_ALL, loc="right")
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
