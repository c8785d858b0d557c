"""Which fleets a trial has: drawn from its seed, nothing chosen by hand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Literal

import numpy as np

from schemas.discrepancy import Review, ReviewFinding
from schemas.recording import Manifest, Recording
from storage.run_statistics import decoded, encoded
from tasks.review.pool import VERSION, ReviewedRun, pooled, statistics_of
from tasks.review.report import review_of
from tasks.review.search import search
from tasks.review.several_recordings import reviewed_runs
from tasks.version import code_version
from tests.proof.plant.case import Case, Data, EffectCall
from tests.proof.plant.effects import effects_of
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import at_visibility, manifest_of, simulate, without_noise
from tests.proof.plant.world import Setting
from tests.proof.study import Count, Out, Seed, Write, answers, folder_of, publish, share, table

Kind = Literal["clean", "station", "station_since", "unit", "model", "site"]
KINDS: tuple[Kind, ...] = ("clean", "station", "station_since", "unit", "model", "site")
SHARES = (0.3, 0.15, 0.2, 0.12, 0.13, 0.1)
STRENGTHS = (3.0, 4.0, 5.0)  # z in one run
OF_STATIONS = (
    "axis_tilt", "axis_nonorthogonality", "axis_wobble", "table_scale", "rate_ripple",
    "encoder_eccentricity", "structural_compliance", "lever_arm", "time_offset",
)  # fmt: skip
OF_UNITS = (
    "gyro_scale_nonlinearity", "gyro_scale_asymmetry", "gyro_g2_sensitivity",
    "gyro_scale_g_dependence", "gyro_angular_acceleration", "accel_nonlinearity", "size_effect",
    "temperature_bias", "supply_sensitivity", "bandwidth", "accel_axis_skew", "lever_arm",
)  # fmt: skip
OF_SITES = ("earth_rotation", "time_offset", "supply_sensitivity")
SPREADING = ("size_effect", "gyro_scale_nonlinearity", "accel_nonlinearity", "gyro_g2_sensitivity")
SPREAD_Z = 1.5  # of the spread between units in one run
LATITUDES, HEADINGS = (39.9, 22.5), (0.0, 37.0, 90.0, -120.0, 180.0, 61.0)
LONG_FLEET, LONGEST, USUAL = 0.12, 400, 80  # share of fleets with up to 400 runs


class FleetRun(Data):
    """One run: whose, where and when; with the carrier's effect or without."""

    seed: int
    day: int
    unit: int
    station: int
    affected: bool


class Fleet(Data):
    """What determines a fleet. models: of each unit. site: of each station. crossed: whether units
    go from station to station. effect: what the affected runs have. spread: by unit, what each has
    of its own. since: the number of the first affected run among the carrier's; None: all are.
    """

    number: int
    kind: Kind
    base: Case
    stations: int
    models: tuple[int, ...]
    sites: tuple[int, ...]
    crossed: bool
    carrier: int
    since: int | None
    z: float | None
    effect: EffectCall | None
    spread: tuple[EffectCall, ...]
    runs: tuple[FleetRun, ...]

    @property
    def level(self) -> str:
        return self.kind.split("_")[0]

    def case_of(self, run: FleetRun) -> Case:
        """The run as the plant plays it."""
        effects = {call.name: call for call in self.spread[run.unit : run.unit + 1]}
        if run.affected and self.effect is not None:
            effects[self.effect.name] = self.effect
        return self.base.model_copy(
            update={
                "seed": run.seed,
                "unit_seed": self.base.seed + 1 + run.unit,
                "latitude_deg": LATITUDES[self.sites[run.station]],
                "heading_deg": HEADINGS[run.station],
                "effects": tuple(effects.values()),
            }
        )


def draw(seed: int, number: int) -> Fleet:
    """A fleet of a trial."""
    rng = np.random.default_rng([seed, number, 17])
    kind: Kind = str(rng.choice(KINDS, p=SHARES))  # type: ignore[assignment]
    stations, units = int(rng.integers(3, 7)), int(rng.integers(8, 41))
    most = LONGEST if rng.uniform() < LONG_FLEET else USUAL
    count = int(np.exp(rng.uniform(np.log(max(48, 2 * units)), np.log(most))))
    base = _base(rng)
    sites = tuple(int(2 * k >= stations) for k in range(stations))
    models = tuple(int(m) for m in rng.integers(0, 2 if units < 20 else 3, units))
    crossed = bool(rng.uniform() < 0.7) or kind == "unit"
    unit_of, station_of = _places(rng, count, units, stations, crossed)
    groups = {
        "unit": unit_of, "station": station_of, "model": np.array(models)[unit_of],
        "site": np.array(sites)[station_of],
    }  # fmt: skip
    level = kind.split("_")[0]
    carrier, affected, since = 0, np.zeros(count, bool), None
    if kind != "clean":
        own = groups[level]
        carrier = int(np.argmax(np.bincount(own))) if level == "unit" else int(rng.choice(own))
        affected = own == carrier
        if kind == "station_since":
            runs = np.flatnonzero(affected)
            since = int(rng.integers(len(runs) // 4, 3 * len(runs) // 4 + 1))
            affected[runs[:since]] = False
    effect, z = _effect(rng, level, base)
    seeds = rng.integers(1, 2**31 - 1, count)
    return Fleet(
        number=number, kind=kind, base=base, stations=stations, models=models, sites=sites,
        crossed=crossed, carrier=carrier, since=since, z=z, effect=effect,
        spread=_spread(rng, base, units, kind == "clean" or bool(rng.uniform() < 0.5), effect),
        runs=tuple(
            FleetRun(seed=int(seeds[k]), day=k, unit=int(unit_of[k]), station=int(station_of[k]),
                     affected=bool(affected[k]))
            for k in range(count)
        ),
    )  # fmt: skip


def drawn_runs(count: int) -> list[ReviewedRun]:
    """Whose so many runs are, one a day, of 400 units that go between six stations."""
    rng = np.random.default_rng(1)
    units, stations = rng.integers(400, size=count), rng.integers(6, size=count)
    return [
        ReviewedRun(
            f"{day:05d}", f"{day:05d}",
            {"unit": f"{unit}", "station": f"{station}", "model": f"{unit % 4}",
             "site": f"{station % 2}"},
        )
        for day, (unit, station) in enumerate(zip(units, stations, strict=True))
    ]  # fmt: skip


def _base(rng: np.random.Generator) -> Case:
    return Case(
        seed=int(rng.integers(1, 1_000_000)),
        grade=str(rng.choice(["consumer", "industrial"])),  # type: ignore[arg-type]
        procedure="three_axis",
        rate_hz=20,
        rates_deg_s=((30.0, 120.0), (40.0, 100.0), (20.0, 150.0))[int(rng.integers(3))],
        dwell_s=5.0,
    )


def _places(
    rng: np.random.Generator, count: int, units: int, stations: int, crossed: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Unit and station (count,) of each run; some come oftener than others, and each comes."""
    weight = rng.dirichlet(np.full(units, 3.0))
    unit = rng.permutation(
        np.concatenate([np.arange(units), rng.choice(units, count - units, p=weight)])
    )
    home = rng.permutation(np.arange(units) % stations)
    station = rng.integers(0, stations, count) if crossed else home[unit]
    return unit, station


def _effect(
    rng: np.random.Generator, level: str, base: Case
) -> tuple[EffectCall | None, float | None]:
    """An effect that the procedure shows, of z = 3 to 5 in one run, with all its parameters."""
    names = {"station": OF_STATIONS, "unit": OF_UNITS, "model": OF_UNITS, "site": OF_SITES}
    z = float(rng.choice(STRENGTHS))
    while level in names:
        sized = _sized(base, str(rng.choice(names[level])), z)
        if sized is not None:
            return sized, z
    return None, None


def _sized(base: Case, name: str, z: float) -> EffectCall | None:
    case = base.model_copy(update={"effects": (EffectCall(name=name),)})
    try:
        noise_free = without_noise(at_visibility(case, name, z))
    except ValueError:
        return None
    return EffectCall(name=name, parameters=dict(noise_free.effects[0].parameters))


def _spread(
    rng: np.random.Generator, base: Case, units: int, spreads: bool, effect: EffectCall | None
) -> tuple[EffectCall, ...]:
    """Of each unit its own value of an effect, about zero; nothing where units do not differ."""
    names = [name for name in SPREADING if effect is None or name != effect.name]
    name = str(rng.choice(names))
    if not spreads:
        return ()
    case = base.model_copy(update={"effects": (EffectCall(name=name),)})
    strength = at_visibility(case, name, SPREAD_Z).effects[0].strength
    sizes = strength * np.sqrt(rng.chisquare(3, units) / 3.0)
    return tuple(_own(base, name, unit, float(size)) for unit, size in enumerate(sizes))


def _own(base: Case, name: str, unit: int, strength: float) -> EffectCall:
    """What one unit has of an effect."""
    call = EffectCall(name=name, strength=strength)
    case = base.model_copy(update={"seed": base.seed + 1 + unit, "effects": (call,)})
    (effect,) = effects_of(case, Setting(case, plan_of(case)))
    return EffectCall(name=name, parameters=dict(effect.parameters))


# A run of a fleet as a recording that tells who, where and when, and nothing of the truth.

BEGINNING = datetime(2025, 3, 1, 8, tzinfo=UTC)


def played(fleet: Fleet, run: FleetRun) -> Recording:
    """The recording of a run."""
    recording = simulate(fleet.case_of(run)).recording
    return replace(recording, manifest=manifest_of_run(fleet, run))


def manifest_of_run(fleet: Fleet, run: FleetRun) -> Manifest:
    """Its manifest, with the names that the fleet has for unit, model, station and site."""
    case = fleet.case_of(run)
    declared = manifest_of(case, plan_of(case)).model_dump(mode="json", exclude_none=True)
    declared["recording_id"] = f"fleet_{fleet.number}_{run.day:04d}"
    declared["acquired_at"] = (BEGINNING + timedelta(days=run.day)).isoformat()
    declared["unit"] |= {"serial": unit_name(run.unit), "model": model_name(fleet.models[run.unit])}
    declared["station"] |= {
        "id": station_name(run.station), "site": site_name(fleet.sites[run.station])
    }  # fmt: skip
    return Manifest.model_validate(declared)


def carrier_name(fleet: Fleet) -> str:
    """The name of what carries the effect."""
    names = {"unit": unit_name, "station": station_name, "model": model_name, "site": site_name}
    return names[fleet.level](fleet.carrier)


def unit_name(number: int) -> str:
    return f"SN{number:04d}"


def station_name(number: int) -> str:
    return f"ST-{number:02d}"


def model_name(number: int) -> str:
    return f"M{number}"


def site_name(number: int) -> str:
    return f"site {number}"


# What a review said of a fleet, against who carries what in it.


@dataclass(frozen=True)
class Judged:
    """One fleet.

    runs: that are affected. name: the effect is found by its name; pair: it is named with others
    from which it cannot be told here. carrier: it is found at what carries it; among: this stands
    among several. since_off: runs of the carrier between the change found
    and the true one; None where there is none to find, or none was found. alarms: findings in a
    clean fleet. wrong: names that nothing in the fleet has.
    """

    fleet: Fleet
    runs: int
    name: bool
    pair: bool
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
    places = _found_at(best) if best and fleet.effect else []
    here = bool(places) and (fleet.level, carrier_name(fleet)) in places
    return Judged(
        fleet=fleet,
        runs=sum(run.affected for run in fleet.runs),
        name=best is not None and best.effect == truth,
        pair=best is not None and bool(best.indistinguishable_from),
        carrier=here and places[0] == (fleet.level, carrier_name(fleet)),
        among=here and len(places) > 1,
        since_off=_since_off(fleet, best) if best and here else None,
        alarms=len(review.findings) if fleet.effect is None else 0,
        wrong=tuple(one.effect for one in review.findings if truth and not _is(one, truth)),
        response="; ".join(_response(one) for one in review.findings) or "nothing",
    )


def _is(finding: ReviewFinding, truth: str) -> bool:
    return truth in (finding.effect, *finding.indistinguishable_from)


def _found_at(finding: ReviewFinding) -> list[tuple[str, str]]:
    """Its carrier, then its alternatives."""
    others = [(str(each.level), each.carrier) for each in finding.alternatives]
    return [(str(finding.level), finding.carrier), *others]


def _response(finding: ReviewFinding) -> str:
    names = " or ".join((finding.effect, *finding.indistinguishable_from))
    where = " or ".join(f"{level} {carrier}" for level, carrier in _found_at(finding))
    return f"{names} at {where}"


def _since_off(fleet: Fleet, finding: ReviewFinding) -> int | None:
    """Runs of the carrier between the first that is found affected and the first that is."""
    if fleet.since is None or finding.since is None:
        return None
    own = [run.day for run in fleet.runs if run.station == fleet.carrier]
    names = [f"fleet_{fleet.number}_{day:04d}" for day in own]
    return abs(names.index(finding.since.run) - fleet.since) if finding.since.run in names else None


# The page of evidence about fleets.

ENOUGH = 25  # runs that the figures ask for at the smallest z
WITHIN = 2  # runs of the carrier
TEXT = """# Fleets: what many runs show together

`make prove ARGS="fleets {count} --seed {seed}"`, {version}. Each fleet is drawn from the seed:
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
tell apart; "alone" counts only what stands by itself. Wrong names are of all findings. Every run of
a fleet follows one procedure: what one run moves alike, a hundred runs move alike, and only another
procedure tells them (`next`).

{fleets}
"""


def page(seed: int, outcomes: Sequence[Judged]) -> str:
    carried = [one for one in outcomes if one.fleet.effect is not None]
    groups = {
        f"{ENOUGH} affected runs or more": [one for one in carried if one.runs >= ENOUGH],
        f"fewer than {ENOUGH} affected runs": [one for one in carried if one.runs < ENOUGH],
        "every fleet": carried,
        **{
            kind.replace("_", " "): [one for one in carried if one.fleet.kind == kind]
            for kind in sorted({one.fleet.kind for one in carried})
        },
    }
    figures = [
        row
        for name, some in groups.items()
        for row in (
            share(f"carrier and name: {name}", "", some, lambda one: one.right),
            share("the same, each alone", "", some, lambda one: one.single),
        )
    ]
    clean = [one for one in outcomes if one.fleet.effect is None]
    dated = [one for one in carried if one.fleet.since is not None]
    figures += [
        share(f"since when, within {WITHIN} runs of the carrier", "90 %", dated,
              lambda one: one.since_off is not None and one.since_off <= WITHIN),
        share("false alarms", "1 %", clean, lambda one: one.alarms > 0),
        share("fleets with a wrong name", "1 %", carried, lambda one: bool(one.wrong)),
    ]  # fmt: skip
    columns = ("", "carried by", "effect", "z", "affected of runs", "found", "right")
    return TEXT.format(
        count=len(outcomes), seed=seed, version=code_version(), figures="\n".join(figures),
        fleets="\n".join(table(columns, map(_row, outcomes))),
    )  # fmt: skip


def _row(one: Judged) -> tuple[object, ...]:
    fleet = one.fleet
    effect, z = (fleet.effect.name, f"{fleet.z:.0f}") if fleet.effect else ("–", "")
    right = "" if fleet.effect is None and not one.alarms else "yes" if one.right else "no"
    affected = f"{one.runs} of {len(fleet.runs)}"
    return fleet.number, fleet.kind.replace("_", " "), effect, z, affected, one.response, right


def fleets(count: Count = 60, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Sealed fleets, reviewed blind: what many runs show together."""
    drawn = [draw(seed, number) for number in range(count)]
    folder = folder_of("fleets", out)
    runs = {f"{seed}-{fleet.number:03d}-{run.day:04d}": (fleet, run)
            for fleet in drawn for run in fleet.runs}  # fmt: skip
    made = answers("runs", runs, _made, folder)
    kept = {(fleet.number, run.day): made[label] for label, (fleet, run) in runs.items()}
    publish("fleets", page(seed, [_reviewed(fleet, kept) for fleet in drawn]), folder, write)


def _made(work: tuple[Fleet, FleetRun]) -> bytes:
    """Plays a run and gives its statistics: all that is seen of it."""
    return encoded(statistics_of(played(*work)), VERSION)


def _reviewed(fleet: Fleet, kept: Mapping[tuple[int, int], bytes]) -> Judged:
    manifests = {f"fleet_{fleet.number}_{r.day:04d}": manifest_of_run(fleet, r) for r in fleet.runs}
    who = reviewed_runs(manifests)
    own = (decoded(kept[fleet.number, run.day], VERSION) for run in fleet.runs)
    pool = pooled([(who[name], each) for name, each in zip(who, own, strict=True)])
    return judged(fleet, review_of(pool, *search(pool)))
