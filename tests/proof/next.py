"""The recording that decides: what `explain` leaves open, and what the proposal of `next` shows."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from schemas.base import Frozen, Unusable
from schemas.orders import NextOrder
from schemas.procedure import Procedure
from storage import settings
from storage.catalogue import runs
from storage.home import Home
from tasks.experiment.choose import open_question
from tasks.explain.explain import explain
from tasks.stages.next_recording import next_recording
from tasks.version import code_version
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import at_visibility, simulate, without_noise
from tests.proof.study import Count, Out, Seed, Write, answers, folder_of, publish, share, table

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
MINUTES = 15.0
SEED_AFTER = 1_000_003  # added to the case's: the proposed run has noise of its own
AHEAD = 16  # cases that are played at a time, until so many as asked stay open


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
        z = float(np.exp(rng.uniform(low, high)))
        try:
            sized = without_noise(at_visibility(case, name, z))
        except ValueError:  # the procedure does not show it
            continue
        # by its parameters, so that the unit has the same in another run
        call = EffectCall(name=name, parameters=dict(sized.effects[0].parameters))
        return case.model_copy(update={"effects": (call,)}), name


class Answer(Frozen):
    """A case that was played to its end.

    effect: the truth. opened: the effects that are open after the first recording, none where
    `explain` names everything by itself. predicted: chi-squared expected of the proposal, and
    minutes that it takes. found: the names of each finding of the proposed recording, with those
    that it cannot tell from it. refusal: why `next` proposes nothing.
    """

    number: int
    effect: str
    opened: tuple[str, ...] = ()
    predicted: float | None = None
    minutes: float | None = None
    found: tuple[tuple[str, ...], ...] = ()
    refusal: str | None = None


def played(seed: int, number: int) -> Answer:
    """The case of a seed, from its first recording to the explanation of the proposed one."""
    case, effect = draw(seed, number)
    recording = simulate(case).recording
    try:
        if open_question(recording) is None:
            return Answer(number=number, effect=effect)
        with TemporaryDirectory() as folder:
            home, out = Home(Path(folder) / "home"), Path(folder) / "next.json"
            run, _ = runs.add(recording, home)
            order = NextOrder(runs=(run.id,), minutes=MINUTES, out=str(out))
            answer = next_recording([run], home, order)
            proposed = settings.read(out, Procedure) if answer.procedure else None
    except Unusable as error:
        return Answer(number=number, effect=effect, refusal=str(error))
    response = Answer(
        number=number, effect=effect, opened=answer.decides,
        predicted=answer.predicted.delta_chi2, minutes=answer.minutes,
    )  # fmt: skip
    if proposed is None:
        return response.model_copy(update={"minutes": None, "refusal": answer.statement.en})
    return response.model_copy(update={"found": _found(case, proposed)})


def _found(case: Case, procedure: Procedure) -> tuple[tuple[str, ...], ...]:
    """What is named of the unit when the proposal is carried out."""
    proposed = case.model_copy(
        update={
            "seed": case.seed + SEED_AFTER, "unit_seed": case.seed, "procedure": "given",
            "given": procedure.model_dump(mode="json"),
        }
    )  # fmt: skip
    return tuple(
        tuple(sorted({one.effect, *one.group, *one.indistinguishable}))
        for one in explain(simulate(proposed).recording).findings
        if one.effect != "unnamed"
    )


def page(seed: int, every: Sequence[Answer]) -> str:
    """The page of all cases that were drawn."""
    opened = [one for one in every if one.opened]
    proposed = [one for one in opened if one.minutes is not None]
    figures = [
        share("a recording is proposed", "", opened, lambda one: one.minutes is not None),
        share("the right single name after it", "95 %", proposed, _is_right),
        share("the same, of several that were open", "",
              [one for one in proposed if len(one.opened) > 1], _is_right),
        share("a wrong name after it", "", proposed,
              lambda one: any(one.effect not in names for names in one.found)),
    ]  # fmt: skip
    rows = (
        (
            one.number, one.effect, " or ".join(one.opened), f"{one.predicted or 0.0:.0f}",
            "–" if one.minutes is None else f"{one.minutes:.1f}",
            one.refusal or "; ".join(" or ".join(names) for names in one.found) or "no name",
        )
        for one in opened
    )  # fmt: skip
    return "\n".join([
        "# The recording that decides", "",
        f'`make prove ARGS="next {len(opened)} --seed {seed}"`, {code_version()}. Cases are drawn '
        "from the seed until so many stay open: a short sequence of the specification of a unit "
        "with one effect, which `explain` suspects only, or cannot tell from another. `next` "
        f"proposes a recording of at most {MINUTES:g} min; the plant, which shares no code with "
        "what explains and proposes, carries its procedure out on the same unit with noise of its "
        f"own; `explain` gets that recording alone. {len(every) - len(opened)} cases more were "
        "named at once, or showed nothing.", "",
        *table(("", "asked", "cases", ""), ()), *figures, "",
        *table(("", "effect", "open", "χ² predicted", "min", "after it"), rows), "",
    ])  # fmt: skip


def _is_right(one: Answer) -> bool:
    """Whether the truth is named, alone and with no other name beside it."""
    return one.found == ((one.effect,),)


def next_(count: Count = 60, seed: Seed = 2, out: Out = None, write: Write = False) -> None:
    """Sealed cases, drawn until N of them stay open, and the recordings that decide them."""
    folder, found = folder_of("next", out), list[Answer]()
    while sum(bool(one.opened) for one in found) < count:
        block = range(len(found), len(found) + AHEAD)
        work = {f"{seed}-{number:04d}": number for number in block}
        found += answers("next", work, partial(played, seed), folder).values()
    publish("next", page(seed, found), folder, write)
