"""Power over visibility: in families of effects, and each effect with its own few cases."""

from collections.abc import Callable, Sequence

from tasks.explain.report.svg import GREY, INK, label, picture
from tests.proof.plant.effects import CATALOGUE, FAMILIES
from tests.proof.trial.limit import power
from tests.proof.trial.pictures.outcome import LEGEND, LIMIT, RIGHT, WRONG, legend, outcome, square
from tests.proof.trial.pictures.panel import Panel
from tests.proof.trial.score import Score
from tests.proof.trial.table import Rate

WIDTH = 1000.0
SERIES = (("detected", INK), ("named right, or a pair with the truth", RIGHT),
          ("a wrong name", WRONG))  # fmt: skip
CALLED = {"timing": "time"}  # as the catalogue has it
KNOWS = "limit: knows the effect's form"
Holds = Callable[[Score], object]
HOLDS: tuple[Holds, ...] = (
    lambda each: each.detected,
    lambda each: each.right_or_twin,
    lambda each: each.wrong_beyond_twins,
)


def alone(scores: Sequence[Score]) -> list[Score]:
    """The cases of one effect of the catalogue at a size asked for."""
    return [each for each in scores if each.kind in ("single", "faint") and each.asked_z]


def by_family(scores: Sequence[Score]) -> dict[str, list[Score]]:
    """Cases of one effect by the catalogue's families, in its order; without empty families."""
    families = {name: {each.name for each in effects} for name, effects in FAMILIES.items()}
    sorted_ = {
        name: [each for each in scores if each.effects[0] in effects]
        for name, effects in families.items()
    }
    return {name: group for name, group in sorted_.items() if group}


def rates_by_z(scores: Sequence[Score], holds: Holds) -> list[tuple[float, Rate]]:
    """How many of the cases of each z asked it holds for."""
    groups: dict[float, list[Score]] = {}
    for each in scores:
        groups.setdefault(each.asked_z or 0.0, []).append(each)
    return [
        (z, Rate(sum(bool(holds(each)) for each in group), len(group)))
        for z, group in sorted(groups.items())
    ]


def limit_of(scores: Sequence[Score]) -> Callable[[float], float]:
    """The power of a detector that knows the form, in the mean over these cases."""
    counts = [next(iter(each.freedom.values())) for each in scores]
    shares = {k: counts.count(k) / len(counts) for k in set(counts)}
    return lambda z: sum(share * power(z, k) for k, share in shares.items())


def families_svg(scores: Sequence[Score]) -> str:
    """A panel for each family: shares of its pooled cases with Wilson's intervals."""
    groups = by_family(alone(scores))
    columns, across, down = 3, 325.0, 205.0
    parts = legend([*SERIES, (KNOWS, LIMIT)], 50.0, 20.0)
    for n, (name, group) in enumerate(groups.items()):
        left, top = 50.0 + across * (n % columns), 66.0 + down * (n // columns)
        panel = Panel(left, top, 262.0, 130.0)
        effects = len({each.effects[0] for each in group})
        said = f"{CALLED.get(name, name)}: effects {effects}, cases {len(group)}"
        parts += [*panel.frame(), panel.title(said), *panel.numbers(top + 146.0)]
        parts.append(panel.curve(limit_of(group), LIMIT))
        for k, (holds, (_, colour)) in enumerate(zip(HOLDS, SERIES, strict=True)):
            parts += panel.series(rates_by_z(group, holds), colour, 5.0 * (k - 1))
    rows = -(-len(groups) // columns)
    height = 66.0 + down * rows
    parts.append(label(WIDTH - 20, height - 12, "z: signal beside the noise", 12, "end", GREY))
    return picture(WIDTH, height, "Power by family", parts)


def effects_svg(scores: Sequence[Score]) -> str:
    """A small panel for each effect: the limit, its family's shares, and its own cases below."""
    columns, across, down = 6, 163.0, 128.0
    parts = [
        *legend([(KNOWS, LIMIT), ("detected in its family", INK), ("named right there", RIGHT)],
                34.0, 18.0, 12),
        *legend([(f"case: {words}", colour) for words, colour in LEGEND], 34.0, 40.0, 12),
    ]  # fmt: skip
    told = [e for e in scores if e.kind in ("single", "faint") and e.can_be_told]
    shown = [
        (name, alone(group), own)
        for group in by_family(told).values()
        for name in CATALOGUE
        if (own := [each for each in group if each.effects[0] == name])
    ]
    for n, (name, family, own) in enumerate(shown):
        panel = Panel(34.0 + across * (n % columns), 78.0 + down * (n // columns), 135.0, 62.0)
        parts += _effect(panel, name, family, own, words=n % columns == 0)
    height = 70.0 + down * -(-len(shown) // columns)
    return picture(WIDTH, height, "Power by effect", parts)


def _effect(
    panel: Panel, name: str, family: Sequence[Score], own: Sequence[Score], words: bool
) -> list[str]:
    parts = [*panel.frame(8.5, words), label(panel.left, panel.top - 6, name, 10.5, bold=True)]
    parts.append(panel.curve(limit_of(own), LIMIT, 1.3))
    for holds, (_, colour) in list(zip(HOLDS, SERIES, strict=True))[:2]:
        parts += panel.series(rates_by_z(family, holds), colour, radius=1.6)
    foot, placed = panel.top + panel.height + 6.0, list[float]()
    for each in sorted(own, key=lambda each: next(iter(each.z.values()))):
        x = panel.x(next(iter(each.z.values()))) - 4.0
        while placed and x < placed[-1] + 9.0:
            x = placed[-1] + 9.0
        placed.append(x)
        parts.append(square(x, foot, outcome(each)[0], 8.0))
    parts += panel.numbers(foot + 20.0, 8.5)
    return parts
