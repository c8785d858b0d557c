"""The scores as figures: rates with their Wilson intervals, by effect and z, and in all."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from tasks.validation.coverage import interval_of_share
from tests.proof.trial.cost import Cost
from tests.proof.trial.score import Score


@dataclass(frozen=True)
class Rate:
    """A count of a count, and the 95 % interval (Wilson) of its probability."""

    count: int
    of: int

    @property
    def share(self) -> float | None:
        return self.count / self.of if self.of else None

    @property
    def interval(self) -> tuple[float, float] | None:
        return interval_of_share(self.count / self.of, self.of) if self.of else None

    def response(self) -> dict[str, object]:
        """As plain data."""
        return {"count": self.count, "of": self.of, "share": self.share, "interval": self.interval}


@dataclass(frozen=True)
class Row:
    """Cases of one kind. parameters: intervals that hold the truth; gap: the median share
    closed; of_closable: that of what noise lets be closed. right: of those that have a name.
    before, after: median of the certificate's largest error, in U, without the findings and with
    them; beyond_before, beyond_after: those above one U; wrong_before, wrong_after: verdicts that
    are not the unit's; unnoticed: certificates whose own evaluation remarks on nothing.
    """

    name: str
    z: float | None
    cases: int
    z_median: float | None
    concealment: float | None
    detected: Rate
    right: Rate
    right_or_twin: Rate
    wrong: Rate
    wrong_beyond_twins: Rate
    abstained: Rate
    found: Rate
    parameters: Rate
    gap: float | None
    gap_worst: float | None
    before: float | None
    after: float | None
    before_most: float | None
    beyond_before: Rate
    beyond_after: Rate
    wrong_before: Rate
    wrong_after: Rate
    unnoticed: Rate
    of_closable: float | None
    seconds: float


def row(name: str, z: float | None, scores: Sequence[Score]) -> Row:
    """The figures of some cases, at least one."""
    gaps = [each.gap.closed for each in scores if each.gap is not None]
    shares = [share for e in scores if e.gap and (share := e.gap.of_closable) is not None]
    observation = [z for each in scores for z in each.z.values()]
    hidden = [share for each in scores for share in each.concealment.values()]
    costs = [each.cost for each in scores if each.cost is not None]
    nameable = [each for each in scores if each.has_a_name]
    pairs = [pair for each in scores for pair in each.parameters]

    def of_costs(holds: Callable[[Cost], bool]) -> Rate:
        return Rate(sum(map(holds, costs)), len(costs))

    def rate(holds: Callable[[Score], object]) -> Rate:
        return Rate(sum(bool(holds(each)) for each in scores), len(scores))

    return Row(
        name=name,
        z=z,
        cases=len(scores),
        z_median=median(observation) if observation else None,
        concealment=median(hidden) if hidden else None,
        detected=rate(lambda each: each.detected),
        right=Rate(sum(each.right for each in nameable), len(nameable)),
        right_or_twin=Rate(sum(each.right_or_twin for each in nameable), len(nameable)),
        wrong=rate(lambda each: each.wrong),
        wrong_beyond_twins=rate(lambda each: each.wrong_beyond_twins),
        abstained=rate(lambda each: each.abstained),
        found=Rate(sum(len(e.named) for e in scores), sum(len(e.effects) for e in scores)),
        parameters=Rate(sum(pair.inside for pair in pairs), len(pairs)),
        gap=median(gaps) if gaps else None,
        gap_worst=min(gaps) if gaps else None,
        before=median(each.before for each in costs) if costs else None,
        after=median(each.after for each in costs) if costs else None,
        before_most=max((each.before for each in costs), default=None),
        beyond_before=of_costs(lambda each: each.before > 1.0),
        beyond_after=of_costs(lambda each: each.after > 1.0),
        wrong_before=of_costs(lambda each: each.wrong_before),
        wrong_after=of_costs(lambda each: each.wrong_after),
        unnoticed=of_costs(lambda each: each.unnoticed),
        of_closable=median(shares) if shares else None,
        seconds=median(each.seconds for each in scores),
    )


def rows_of(scores: Sequence[Score]) -> list[Row]:
    """By effect and z asked; several effects by their number; the clean ones first."""
    groups: dict[tuple[int, str, float], list[Score]] = {}
    for each in scores:
        groups.setdefault(_place(each), []).append(each)
    return [row(name, group[0].asked_z, group) for (_, name, _), group in sorted(groups.items())]


def _place(each: Score) -> tuple[int, str, float]:
    if not each.effects:
        return 0, "clean", 0.0
    z = each.asked_z or 0.0
    if each.kind == "several":
        return 3, f"{len(each.effects)} effects together", z
    return (2 if each.kind == "outside" else 1), each.effects[0], z


def by_effect(scores: Sequence[Score]) -> list[Row]:
    """Every effect alone, whatever its z, what costs most first; what has no name comes last."""
    groups: dict[str, list[Score]] = {}
    for each in scores:
        if len(each.effects) == 1:
            groups.setdefault(each.effects[0], []).append(each)
    rows = [row(name, None, group) for name, group in groups.items()]
    return sorted(rows, key=lambda each: (each.name.startswith("x_"), -(each.before or 0.0)))


def totals_of(scores: Sequence[Score]) -> dict[str, Row]:
    """The headline: clean cases, single effects by z, several, what is outside the catalogue."""
    single = [each for each in scores if each.kind == "single"]
    kinds: dict[str, Iterable[Score]] = {
        "clean": (each for each in scores if each.kind == "clean"),
        "one effect, z 5": (each for each in scores if each.kind == "faint"),
        **{
            f"one effect, z {z:g}": [each for each in single if each.asked_z == z]
            for z in sorted({each.asked_z for each in single if each.asked_z})
        },
        "one effect, z 10 and more": (each for each in single if each.asked_z),
        "Earth as it is": (each for each in single if each.effects == ("earth_rotation",)),
        "cannot be told": (each for each in single if not each.can_be_determined),
        "several effects": (each for each in scores if each.kind == "several"),
        "outside the catalogue": (each for each in scores if each.kind == "outside"),
    }
    listed = {name: list(group) for name, group in kinds.items()}
    return {name: row(name, None, group) for name, group in listed.items() if group}
