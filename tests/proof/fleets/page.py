"""The page of evidence about fleets."""

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

from tasks.version import code_version
from tests.proof.fleets.judge import Judged
from tests.proof.report import line, share

ENOUGH = 25  # runs that the figures ask for at the smallest z
SMALLEST = 3.0  # z
WITHIN = 2  # runs of the carrier
RIGHT, SINGLE = attrgetter("right"), attrgetter("single")

TEXT = """# Fleets: what many runs show together

`make prove ARGS="--fleets {count} --seed {seed}"`, {version}. Each fleet is drawn from the seed:
stations, units, models, sites, who runs where and when, and an effect that has z = 3 to 5 in one
run and is carried by a station (from the first run or since a date), a unit, a model or a site; or
none. In some fleets every unit has a little of another effect of its own, which is no mismatch.
The recordings are short (four minutes at 20 Hz, of consumer and industrial grade), made by a plant
that shares no code with what explains them. `review` gets their statistics and manifests.
The fleets of seeds 1, 3, 5 and 6 and the first 22 of seed 2 were looked at while `review` was made.
Those of further seeds are unseen.

| | asked | fleets | |
|---|--:|--:|--:|
{figures}

Carrier and name are right where both are stated, alone or as one of those that the runs cannot
tell apart; "alone" counts only what stands by itself. Wrong names are of all findings. The evidence
of n runs is z·√n: {enough} runs at z = 3 have 15.

Where carrier and name are right and do not stand alone, there stands beside them:
{beside}.
Every run of a fleet follows one procedure: what one run moves alike, a hundred runs move alike, and
only another procedure tells them (`next`).

## What one run shows

`explain` on one affected run of each fleet, alone: {alone}.

## Many runs

{many:,} kept statistics of {size:.0f} kB each (100,000 runs: {disk:.1f} GB) are read in
{read:.1f} s and searched in {search:.1f} s (asked: 10 s), by one process of a computer with
{cores} cores and a load of {load:.1f}; in {processor:.1f} s of processor time together.
Every finding makes the search longer: `make bench` times one in which there are several.

## Each fleet

| | carried by | effect | z | affected of runs | z·√n | found | right |
|--:|---|---|--:|--:|--:|---|---|
{fleets}
"""


@dataclass(frozen=True)
class Alone:
    """What `explain` says of one affected run: the one right name; among several; a wrong one."""

    named: bool
    among: bool
    wrong: bool


@dataclass(frozen=True)
class Many:
    """A search over many statistics: s to read them and to search, s of processor time for both,
    mean size of one in bytes.
    """

    count: int
    read_s: float
    search_s: float
    processor_s: float
    size: float


def page(seed: int, outcomes: Sequence[Judged], alone: Sequence[Alone | None], many: Many) -> str:
    """The page; outcomes and what one run shows: of each fleet."""
    return TEXT.format(
        count=len(outcomes), seed=seed, version=code_version(), figures=_figures(outcomes),
        enough=ENOUGH, beside=_beside(outcomes),
        alone=_alone([one for one in alone if one is not None]), many=many.count,
        size=many.size / 1e3, disk=many.size * 1e5 / 1e9, read=many.read_s, search=many.search_s,
        processor=many.processor_s,
        cores=os.cpu_count(), load=os.getloadavg()[0], fleets="\n".join(map(_row, outcomes)),
    )  # fmt: skip


def _figures(outcomes: Sequence[Judged]) -> str:
    carried = [one for one in outcomes if one.fleet.effect is not None]
    enough = [one for one in carried if one.runs >= ENOUGH]
    fewer = [one for one in carried if one.runs < ENOUGH]
    clear = [one for one in carried if _evidence(one) >= SMALLEST * ENOUGH**0.5]
    clean = [one for one in outcomes if one.fleet.effect is None]
    dated = [one for one in carried if one.fleet.since is not None]
    kinds = sorted({one.fleet.kind for one in carried})
    rows = [
        share(f"carrier and name, {ENOUGH} affected runs or more", "90 %", enough, RIGHT),
        share("the same, each alone", "", enough, SINGLE),
        share("carrier and name, z·√n of 15 or more", "", clear, RIGHT),
        share("the same, each alone", "", clear, SINGLE),
        share(f"carrier and name, fewer than {ENOUGH} affected runs", "", fewer, RIGHT),
        share("the same, each alone", "", fewer, SINGLE),
        share("carrier and name, every fleet", "", carried, RIGHT),
        share("the same, each alone", "", carried, SINGLE),
        *(
            share(f"carrier and name: {kind.replace('_', ' ')}", "",
                  [one for one in carried if one.fleet.kind == kind], RIGHT)
            for kind in kinds
        ),
        share(f"since when, within {WITHIN} runs of the carrier", "90 %", dated, _dated),
        share("false alarms", "1 %", clean, lambda one: one.alarms > 0),
        share("fleets with a wrong name", "1 %", carried, lambda one: bool(one.wrong)),
    ]  # fmt: skip
    return "\n".join(rows)


def _evidence(one: Judged) -> float:
    """z of all affected runs together."""
    return (one.fleet.z or 0.0) * float(one.runs) ** 0.5


def _beside(outcomes: Sequence[Judged]) -> str:
    """What stands beside right names, and how often."""
    pairs = Counter(
        f"{one.fleet.effect.name} with {', '.join(sorted(one.names - {one.fleet.effect.name}))}"
        for one in outcomes
        if one.fleet.effect is not None and one.right and one.pair
    )
    places = sum(one.right and one.among for one in outcomes)
    listed = [f"{pair} ({count})" for pair, count in pairs.most_common()]
    return "; ".join([*listed, f"another carrier ({places})"])


def _dated(one: Judged) -> bool:
    return one.since_off is not None and one.since_off <= WITHIN


def _alone(some: Sequence[Alone]) -> str:
    named, among, wrong = (
        sum(getattr(one, name) for one in some) for name in ("named", "among", "wrong")
    )
    return (
        f"the one right name in {named} of {len(some)}, the right one alone or among several in "
        f"{among}, a wrong one in {wrong}"
    )


def _row(one: Judged) -> str:
    fleet = one.fleet
    effect = fleet.effect.name if fleet.effect else "–"
    z = "" if fleet.z is None else f"{fleet.z:.0f}"
    right = "" if fleet.effect is None and not one.alarms else "yes" if one.right else "no"
    kind = fleet.kind.replace("_", " ")
    all_runs = "" if fleet.z is None else f"{_evidence(one):.0f}"
    affected = f"{one.runs} of {len(fleet.runs)}"
    return line((fleet.number, kind, effect, z, affected, all_runs, one.response, right))
