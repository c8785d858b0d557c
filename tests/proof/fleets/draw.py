"""Which fleets a trial has: drawn from its seed, nothing chosen by hand."""

from typing import Literal

import numpy as np

from tasks.review.pool import ReviewedRun
from tests.proof.plant.case import Case, Data, EffectCall
from tests.proof.plant.effects import effects_of
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import at_visibility, without_noise
from tests.proof.plant.world import Setting

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
