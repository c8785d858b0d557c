"""The scores of a rough trial as figures."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

from tests.proof.trial.compare import Compared
from tests.proof.trial.evidence import rate_words
from tests.proof.trial.rough.score import PLAIN, RoughScore
from tests.proof.trial.table import Rate

COLUMNS = (
    "recordings", "number", "any finding named", "a wrong name", "a wrong name, the right one in "
    "its group", f"named at z ≥ {PLAIN:g}", "or in a group", "95 % intervals", "χ²/dof after",
    "no answer", "seconds",
)  # fmt: skip
AGREE = ("χ²/dof after", "parameters", "95 % intervals", "|error| over u, median")
CLASSES = ((0.0, 2.0), (2.0, 10.0), (10.0, float("inf")))


@dataclass(frozen=True)
class RoughRow:
    """Recordings of one kind. named, in_group: of the listed effects that stand at z ≥ 30."""

    name: str
    recordings: int
    any_named: Rate
    wrong: Rate
    wrong_in_group: Rate
    named: Rate
    in_group: Rate
    intervals: Rate
    left: float | None
    failed: int
    seconds: float

    def cells(self) -> list[str]:
        """As words, in the order of COLUMNS."""
        rates = (
            self.any_named, self.wrong, self.wrong_in_group, self.named, self.in_group,
            self.intervals,
        )  # fmt: skip
        return [
            self.name,
            f"{self.recordings}",
            *(f"{rate.count}/{rate.of} = {rate_words(rate, True)}" if rate.of else "–"
              for rate in rates),
            "–" if self.left is None else f"{self.left:.3g}",
            f"{self.failed}",
            f"{self.seconds:.0f}",
        ]  # fmt: skip


def rows_rough(scores: Sequence[RoughScore]) -> list[RoughRow]:
    """All together, then by run and by kind."""
    parts = {
        getattr(each, sort): [one for one in scores if getattr(one, sort) == getattr(each, sort)]
        for sort in ("run", "kind")
        for each in sorted(scores, key=lambda one: str(getattr(one, sort)))
    }
    return [_row("all", scores), *(_row(name, part) for name, part in parts.items())]


def _row(name: str, scores: Sequence[RoughScore]) -> RoughRow:
    answered = [each for each in scores if each.failed is None]
    plain = [one for each in answered for one in each.listed if one.z >= PLAIN]
    pairs = [pair for each in answered for pair in each.parameters]
    left = [each.worst_left for each in answered if each.worst_left is not None]

    def share(holds: Callable[[RoughScore], object]) -> Rate:
        return Rate(sum(bool(holds(each)) for each in answered), len(answered))

    return RoughRow(
        name=name,
        recordings=len(scores),
        any_named=share(lambda each: set(each.names) - {"unnamed"}),
        wrong=share(lambda each: each.wrong),
        wrong_in_group=share(lambda each: each.in_group),
        named=Rate(sum(one.named for one in plain), len(plain)),
        in_group=Rate(sum(one.named or one.in_group for one in plain), len(plain)),
        intervals=Rate(sum(pair.inside for pair in pairs), len(pairs)),
        left=median(left) if left else None,
        failed=len(scores) - len(answered),
        seconds=median(each.seconds for each in scores),
    )


def agreement(scores: Sequence[RoughScore]) -> list[list[str]]:
    """What is left beside what U says of it: errors over u where more and less is left."""
    rows = []
    for low, high in CLASSES:
        pairs = [
            pair
            for each in scores
            if each.worst_left is not None and low <= each.worst_left < high
            for pair in each.parameters
        ]
        words = f"{low:g} to {high:g}" if high < float("inf") else f"{low:g} and more"
        rows.append([words, f"{len(pairs)}", *_held(pairs)])
    return rows


def _held(pairs: Sequence[Compared]) -> tuple[str, str]:
    if not pairs:
        return "–", "–"
    inside = Rate(sum(pair.inside for pair in pairs), len(pairs))
    errors = median(abs(pair.found - pair.true) / pair.u for pair in pairs)
    return f"{inside.count}/{inside.of} = {rate_words(inside, True)}", f"{errors:.2g}"


CASES = ("recording", "kind", "run", "hidden (z)", "brought by the reference", "said", "wrong",
         "χ²/dof after", "s")  # fmt: skip


def cases(scores: Sequence[RoughScore]) -> list[list[str]]:
    """Every recording, those with a wrong name first; in the order of CASES."""
    return [
        [
            each.number,
            each.kind,
            each.run,
            ", ".join(_hidden(each)) or "nothing",
            ", ".join(each.nuisances) or "nothing",
            f"no answer: {each.failed}"
            if each.failed is not None
            else ", ".join(each.names) or "nothing",
            ", ".join(each.wrong),
            "–" if each.worst_left is None else f"{each.worst_left:.3g}",
            f"{each.seconds:.0f}",
        ]
        for each in sorted(scores, key=lambda each: (not each.wrong, each.number))
    ]


def _hidden(score: RoughScore) -> list[str]:
    listed = {one.called: one.z for one in score.listed}
    return [f"{name} ({listed[name]:.0f})" if name in listed else name for name in score.truth]
