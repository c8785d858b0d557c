"""What a review said of a fleet, against who carries what in it."""

from dataclasses import dataclass

from schemas.review import Review, ReviewFinding
from tests.proof.fleets.draw import Fleet
from tests.proof.fleets.play import carrier_name


@dataclass(frozen=True)
class Judged:
    """One fleet.

    runs: that are affected. name: the effect is found by its name; pair: it is named with others
    from which it cannot be told here. names: of that finding. carrier: it is found at what carries
    it; among: this stands among several. since_off: runs of the carrier between the change found
    and the true one; None where there is none to find, or none was found. alarms: findings in a
    clean fleet. wrong: names that nothing in the fleet has.
    """

    fleet: Fleet
    runs: int
    name: bool
    pair: bool
    names: frozenset[str]
    carrier: bool
    among: bool
    since_off: int | None
    alarms: int
    wrong: tuple[str, ...]
    response: str

    @property
    def right(self) -> bool:
        """Carrier and name, or each said to be one of those that cannot be told apart."""
        return (self.name or self.pair) and (self.carrier or self.among)

    @property
    def single(self) -> bool:
        """Carrier and name, and nothing else."""
        return self.name and not self.pair and self.carrier and not self.among


def judged(fleet: Fleet, review: Review) -> Judged:
    """The answer held against the truth."""
    truth = fleet.effect.name if fleet.effect else ""
    own = [one for one in review.findings if _is(one, truth)]
    best = own[0] if own else None
    places = _places(best) if best and fleet.effect else []
    here = bool(places) and (fleet.level, carrier_name(fleet)) in places
    return Judged(
        fleet=fleet,
        runs=sum(run.affected for run in fleet.runs),
        name=best is not None and best.effect == truth,
        pair=best is not None and bool(best.indistinguishable_from),
        names=frozenset((best.effect, *best.indistinguishable_from) if best else ()),
        carrier=here and places[0] == (fleet.level, carrier_name(fleet)),
        among=here and len(places) > 1,
        since_off=_since_off(fleet, best) if best and here else None,
        alarms=len(review.findings) if fleet.effect is None else 0,
        wrong=tuple(one.effect for one in review.findings if truth and not _is(one, truth)),
        response="; ".join(_response(one) for one in review.findings) or "nothing",
    )


def _is(finding: ReviewFinding, truth: str) -> bool:
    return truth in (finding.effect, *finding.indistinguishable_from)


def _places(finding: ReviewFinding) -> list[tuple[str, str]]:
    """Its carrier, then its alternatives."""
    others = [(str(each.level), each.carrier) for each in finding.alternatives]
    return [(str(finding.level), finding.carrier), *others]


def _response(finding: ReviewFinding) -> str:
    names = " or ".join((finding.effect, *finding.indistinguishable_from))
    where = " or ".join(f"{level} {carrier}" for level, carrier in _places(finding))
    return f"{names} at {where}"


def _since_off(fleet: Fleet, finding: ReviewFinding) -> int | None:
    """Runs of the carrier between the first that is found affected and the first that is."""
    if fleet.since is None or finding.since is None:
        return None
    own = [run.day for run in fleet.runs if run.station == fleet.carrier]
    names = [f"fleet_{fleet.number}_{day:04d}" for day in own]
    return abs(names.index(finding.since.run) - fleet.since) if finding.since.run in names else None
