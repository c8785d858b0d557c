"""Which recordings may leave something open: drawn from a seed, nothing chosen by hand."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from schemas.base import Frozen, Unusable
from schemas.discrepancy import NextRecording
from schemas.orders import NextOrder
from schemas.procedure import Procedure
from schemas.recording import Recording
from schemas.station import StationFile
from storage import settings
from storage.catalogue import runs
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from tasks.experiment.blocks import Abilities
from tasks.experiment.choose import open_question
from tasks.experiment.separation import left_by_real_fit
from tasks.explain.explain import explain
from tasks.explain.search.stepwise import HOLDS
from tasks.stages.next_recording import next_recording
from tasks.station.virtual.config import VirtualStation
from tasks.version import code_version
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import at_visibility, simulate, without_noise
from tests.proof.plant.world import STATED_K_S
from tests.proof.station import Case as StationCase
from tests.proof.station import shortened
from tests.proof.study import (
    Count,
    Out,
    Seed,
    Write,
    answers,
    folder_of,
    hold,
    line,
    publish,
    share,
)
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.sample_stations import sample

EFFECTS = (
    "lever_arm", "size_effect", "gyro_scale_nonlinearity", "gyro_scale_asymmetry",
    "gyro_g2_sensitivity", "gyro_scale_g_dependence", "accel_nonlinearity",
    "structural_compliance", "axis_wobble", "rate_ripple", "temperature_bias",
)  # fmt: skip
DELAYS = ("time_offset", "bandwidth", "gyro_angular_acceleration")  # hardly ever told apart
OF_DELAYS = 0.05  # of all that is drawn: they stay open far oftener than the others
VISIBLE = (5.5, 30.0)  # z in the first recording, from and to
RATES_HZ = (50, 100)
RATES_DEG_S = ((30.0, 120.0), (40.0, 100.0, 200.0), (20.0, 150.0))


WITH_CHAMBER = 0.5  # of the stations


def has_chamber(seed: int, number: int) -> bool:
    """Whether the station of a case has a chamber whose temperature can be set."""
    return bool(np.random.default_rng([seed, number, 176]).uniform() < WITH_CHAMBER)


def draw(seed: int, number: int) -> tuple[Case, str]:
    """A short recording of the specification's sequence, and the effect that it has."""
    rng = np.random.default_rng([seed, number, 175])
    low, high = np.log(VISIBLE)
    while True:
        name = str(rng.choice(DELAYS if rng.uniform() < OF_DELAYS else EFFECTS))
        case = Case(
            seed=int(rng.integers(1, 1_000_000)),
            grade=str(rng.choice(["consumer", "industrial"])),  # type: ignore[arg-type]
            procedure="three_axis",
            rate_hz=int(rng.choice(RATES_HZ)),
            rates_deg_s=RATES_DEG_S[int(rng.integers(len(RATES_DEG_S)))],
            dwell_s=5.0,
            effects=(EffectCall(name=name),),
        )
        try:
            noise_free = without_noise(
                at_visibility(case, name, float(np.exp(rng.uniform(low, high))))
            )
        except ValueError:  # the procedure does not show it
            continue
        # by its parameters, so that the unit has the same in another run
        call = EffectCall(name=name, parameters=dict(noise_free.effects[0].parameters))
        return case.model_copy(update={"effects": (call,)}), name


# One case: what `explain` leaves open, what `next` proposes, and what the proposal then shows.

MINUTES = 15.0
SEED_AFTER = 1_000_003  # added to the case's: the proposed run has noise of its own


class Answer(Frozen):
    """A case that was played to its end.

    effect: the truth. chamber: whether the station can set its chamber. opened: the effects that
    are open after the first recording, none where `explain` names everything by itself. predicted,
    repeated: chi-squared expected of the proposal, and of the first recording once more; minutes,
    base_minutes: that they take. found: the names of each finding of the proposed recording, with
    those that it cannot tell from it. achieved: chi-squared by which it tells the truth from the
    nearest other; None without a recording or where the truth is not among them. refusal: why
    `next` proposes nothing.
    """

    number: int
    effect: str
    chamber: bool = False
    opened: tuple[str, ...] = ()
    predicted: float | None = None
    probability: float | None = None
    minutes: float | None = None
    base_minutes: float | None = None
    repeated: float | None = None
    found: tuple[tuple[str, ...], ...] = ()
    achieved: float | None = None
    refusal: str | None = None

    @property
    def is_proposed(self) -> bool:
        return self.minutes is not None

    @property
    def per_minute(self) -> float | None:
        """Chi-squared per minute of the proposal, in that of the first recording once more."""
        if not (self.minutes and self.base_minutes and self.repeated and self.predicted):
            return None
        return (self.predicted / self.minutes) / (self.repeated / self.base_minutes)

    @property
    def is_right(self) -> bool:
        """Whether the truth is named, alone and with no other name beside it."""
        return self.found == ((self.effect,),)

    @property
    def is_wrong(self) -> bool:
        """Whether a name is said that the recording does not have."""
        return any(self.effect not in names for names in self.found)


def played(seed: int, number: int) -> Answer:
    """The case of a seed, from its first recording to the explanation of the proposed one."""
    case, effect = draw(seed, number)
    recording = simulate(case).recording
    try:
        question = open_question(recording)
    except Unusable as error:
        return Answer(number=number, effect=effect, refusal=str(error))
    if question is None:
        return Answer(number=number, effect=effect)
    chamber = has_chamber(seed, number)
    with TemporaryDirectory() as folder:
        station = _station_with_chamber(recording, Path(folder)) if chamber else None
        answer = _decided(number, effect, case, recording, Path(folder), station)
    return answer.model_copy(update={"chamber": chamber})


def _station_with_chamber(recording: Recording, folder: Path) -> str:
    """A station file: the recording's own table, and a chamber that can be set."""
    able, file = Abilities.of_recording(recording), sample()
    axes = {
        axis.name: {
            "rate_deg_s": rate, "acceleration_deg_s2": able.acceleration_deg_s2,
            "angle_deg": None if endless else (-360.0, 360.0),
        }
        for axis, rate, endless in zip(
            able.station.table_axes or (), able.rates_deg_s, able.endless, strict=True
        )
    }  # fmt: skip
    file["limits"]["axes"] = axes
    file["limits"]["chamber"]["rate_k_min"] = 60.0 * STATED_K_S
    file |= {"station": able.station, "mount": able.mount, "unit": recording.manifest.unit}
    path = folder / "station.json"
    path.write_text(StationFile.model_validate(file).model_dump_json(), encoding="utf-8")
    return str(path)


def _decided(
    number: int, effect: str, case: Case, recording: Recording, folder: Path, station: str | None
) -> Answer:
    home, out = Home(folder / "home"), folder / "next.json"
    run, _ = runs.add(recording, home)
    order = NextOrder(runs=(run.id,), minutes=MINUTES, out=str(out), station=station)
    try:
        answer = next_recording([run], home, order)
    except Unusable as error:
        return Answer(number=number, effect=effect, refusal=str(error))
    response = Answer(
        number=number, effect=effect, opened=answer.decides,
        predicted=answer.predicted.delta_chi2, probability=answer.predicted.probability_right,
        minutes=answer.minutes, base_minutes=answer.repeat_of_base.minutes,
        repeated=answer.repeat_of_base.delta_chi2,
    )  # fmt: skip
    if answer.procedure is None:
        return response.model_copy(update={"refusal": answer.statement.en})
    return response.model_copy(update=_after(effect, case, answer, settings.read(out, Procedure)))


def _after(
    effect: str, case: Case, answer: NextRecording, procedure: Procedure
) -> dict[str, object]:
    """What the unit shows when the proposal is carried out."""
    proposed = case.model_copy(
        update={
            "seed": case.seed + SEED_AFTER,
            "unit_seed": case.seed,
            "procedure": "given",
            "given": procedure.model_dump(mode="json"),
        }
    )
    recording = simulate(proposed).recording
    findings = explain(recording).findings
    found = tuple(
        tuple(sorted({one.effect, *one.group, *one.indistinguishable}))
        for one in findings
        if one.effect != "unnamed"
    )
    return {"found": found, "achieved": _achieved(effect, recording, answer.decides)}


def _achieved(effect: str, recording: Recording, names: Sequence[str]) -> float | None:
    """Chi-squared by which the nearest other fits worse than the truth; None without the truth.

    An effect of which the truth is a special case fits as well: of it counts what the recording
    would have shown of a typical departure.
    """
    if effect not in names:
        return None
    try:
        # The truth first: the noise is taken from what the first one leaves.
        question = open_question(recording, sorted(names, key=lambda name: name != effect))
    except Unusable:
        return None
    if question is None:
        return None
    blocks, noises = question.fit.blocks, question.fit.noises
    left = {
        name: left_by_real_fit(model, blocks, noises) for name, model in question.models.items()
    }
    general = HOLDS.get(effect)
    shown = [left[name] - left[effect] for name in left if name not in (effect, general)]
    if general is not None and general in question.models:
        readings = np.nan_to_num(question.models[general].prediction(blocks.motion))
        departed = replace(blocks, readings=readings)
        shown.append(left_by_real_fit(question.models[effect], departed, noises))
    return min(shown)


# The page of evidence about proposed recordings.

THERMAL = ("temperature_bias", "thermal_gradient", "thermal_transient")
FACTOR = 2.0  # of the evidence achieved beside that predicted
TEXT = """# The recording that decides

`make prove ARGS="next {count} --seed {seed}"`, {version}. Cases are drawn from the seed until so
many of them stay open: a short sequence of the specification (five minutes, of consumer and
industrial grade) of a unit with one effect, which `explain` suspects only, or cannot tell from
another. `next` proposes a recording of at most {minutes:g} min; the plant carries its procedure
out on the same unit with noise of its own; `explain` gets that recording alone. The plant shares
no code with what explains and proposes. {looked}

| | asked | cases | |
|---|--:|--:|--:|
{figures}

`explain` named the effect by itself, or saw nothing, in {closed} cases more. Half of the stations
have a chamber that can be set (0 to 50 °C, said to change by 4 K/min; the plant's is 15 % slower to
10 % faster, and the unit follows by its warm-up's time constant within 25 %). Nothing is proposed
where no recording of the station decides, and the statement then says what would: a table moves no
temperature; and a low-pass departs from a delay only near its corner. Of second order it is late
by √2/(2πf_c), and what is left of it at f beside such a delay is (f/f_c)²/3 of what the delay
shows: χ² of 54 between the two needs 490·(f_c/f)⁴ of the delay itself.

Per minute of the station the proposed recording shows {per_minute:.1f} times the chi-squared
between the competing models that repeating the whole sequence would (median).

| | effect | chamber | open | χ² predicted | achieved | min | base: χ² | min | after it |
|--:|---|---|---|--:|--:|--:|--:|--:|---|
{cases}
"""
LOOKED = "Cases of seeds 1 and 3 were looked at while `next` was made; those of others are unseen."


def page(seed: int, answers: Sequence[Answer]) -> str:
    """The page of all cases that were drawn."""
    opened = [one for one in answers if one.opened]
    ratios = sorted(one.per_minute for one in opened if one.per_minute is not None)
    return TEXT.format(
        count=len(opened), seed=seed, version=code_version(), minutes=MINUTES, looked=LOOKED,
        figures=_figures(opened), closed=len(answers) - len(opened),
        per_minute=ratios[len(ratios) // 2] if ratios else 0.0,
        cases="\n".join(map(_row, opened)),
    )  # fmt: skip


def _figures(opened: Sequence[Answer]) -> str:
    proposed = [one for one in opened if one.is_proposed]
    declared = [one for one in proposed if one.achieved is not None]
    pairs = [one for one in proposed if len(one.opened) > 1]
    single = [one for one in proposed if len(one.opened) == 1]
    thermal = [one for one in opened if one.chamber and one.effect in THERMAL]
    return "\n".join([
        share("a recording is proposed", "", opened, lambda one: one.is_proposed),
        share("the same, of a thermal effect at a station with a chamber", "", thermal,
              lambda one: one.is_proposed),
        share("the right single name after it", "95 %", proposed, lambda one: one.is_right),
        share("the same, of several that were open", "", pairs, lambda one: one.is_right),
        share("the same, of one that was suspected", "", single, lambda one: one.is_right),
        share("a wrong name after it", "", proposed, lambda one: one.is_wrong),
        share(f"evidence within a factor {FACTOR:g}", "90 %", declared, _near),
    ])  # fmt: skip


def _near(one: Answer) -> bool:
    ratio = (one.achieved or 0.0) / (one.predicted or 1.0)
    return 1.0 / FACTOR <= ratio <= FACTOR


def _row(one: Answer) -> str:
    after = "; ".join(" or ".join(names) for names in one.found) or "no name"
    cells = [
        str(one.number), one.effect, "yes" if one.chamber else "", " or ".join(one.opened),
        _number(one.predicted, 0), _number(one.achieved, 0), _number(one.minutes, 1),
        _number(one.repeated, 0), _number(one.base_minutes, 1),
        after if one.is_proposed else "not proposed",
    ]  # fmt: skip
    return line(cells)


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


AHEAD = 16  # cases that are played at a time, until so many as asked stay open


def next_(count: Count = 60, seed: Seed = 2, out: Out = None, write: Write = False) -> None:
    """Sealed cases, drawn until N of them stay open, and the recordings that decide them."""
    folder, found = folder_of("next", out), list[Answer]()
    while len(_open(found)) < count:
        block = range(len(found), len(found) + AHEAD)
        work = {f"{seed}-{number:04d}": number for number in block}
        found += answers("next", work, partial(played, seed), folder).values()
    publish("next", page(seed, found), folder, write)


def _open(answers: Sequence[Answer]) -> list[Answer]:
    return [one for one in answers if one.opened]


# Once on the virtual station: acquire, explain (several names), next, acquire, explain (one).

SPEED = 200.0  # station seconds in a second of the simulated wall clock
SPREAD_M = 0.45e-3  # of the accelerometers about the intersection of the table's axes
UNIT, PLACES = 3, 9  # seeds

STATION_TEXT = """# The recording that decides, on the virtual station

`make prove ARGS="next-station --minutes {most:g}"`. Accelerometers at {places}
(mm, x, y, z each); nothing else that the standard leaves out but Earth's rotation. The truth is a
size effect.

1. `acquire` of JJF 2003's sequence with short dwells, {base:.1f} min; `explain` says: {first}.
2. `next --minutes {most:g}`: {sentence}
3. `acquire --procedure`, {seconds:.1f} min; `explain` says: {second}.
"""


@dataclass(frozen=True)
class Named:
    """What `explain` says: the names of each finding, with those it cannot be told from."""

    names: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        return "; ".join(" or ".join(each) for each in self.names) or "nothing"


def next_station(
    minutes: Annotated[int, typer.Option(metavar="MINUTES", min=1, help="Of the proposal.")] = 15,
    out: Out = None, write: Write = False,
) -> None:  # fmt: skip
    """The same on the virtual station, once: acquire, explain, next, acquire, explain."""
    hold("next-station", {f"{minutes}": minutes}, _on_station, "".join, out, write=write, at_once=0)


def _on_station(minutes: int) -> str:
    with TemporaryDirectory() as work:
        return _played(Path(work), minutes)


def _played(folder: Path, minutes: int) -> str:
    station = _station()
    first = _acquired(station, shortened("jjf2003"), folder / "first.mcap")
    home, out = Home(folder / "home"), folder / "next.json"
    run, _ = runs.add(first, home)
    order = NextOrder(runs=(run.id,), minutes=minutes, out=str(out))
    answer: NextRecording = next_recording([run], home, order)
    second = _acquired(station, settings.read(out, Procedure), folder / "second.mcap")
    return STATION_TEXT.format(
        places="; ".join(_millimetres(place) for place in station.unit.places_m),
        base=first.imu.t[-1] / 60.0, first=_response(first), most=minutes,
        sentence=answer.statement.en, seconds=second.imu.t[-1] / 60.0, second=_response(second),
    )  # fmt: skip


def _station() -> VirtualStation:
    """A unit without drift by temperature and without filters, its accelerometers apart."""
    station = StationCase(UNIT, "jjf2003", has_low_pass=False, has_delay=False).station
    places = np.random.default_rng(PLACES).normal(0.0, SPREAD_M, (3, 3)).tolist()
    steady = {
        name: getattr(station.unit, name).model_copy(update={"bias_per_kelvin": (0.0, 0.0, 0.0)})
        for name in ("gyro", "accel")
    }
    unit = station.unit.model_copy(update=steady | {"places_m": tuple(map(tuple, places))})
    return station.model_copy(update={"unit": unit})


def _acquired(station: VirtualStation, procedure: Procedure, path: Path) -> Recording:
    with RawWriter(path) as sink:
        InMemoryStation(station, SPEED).acquire(procedure, sink)
    return read_mcap(path)


def _response(recording: Recording) -> Named:
    return Named(
        tuple(
            tuple(dict.fromkeys((one.effect, *one.group, *one.indistinguishable)))
            for one in explain(recording).findings
        )
    )


def _millimetres(place: Sequence[float]) -> str:
    return ", ".join(f"{1e3 * each:.2f}" for each in place)
