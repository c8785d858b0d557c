"""Which rough recordings a trial has: drawn from its seed, nothing chosen by hand."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Annotated, Any, Literal

import numpy as np
import typer

from schemas.base import Unusable
from tests.proof.plant.case import Case, Data, EffectCall
from tests.proof.plant.effects.memory import BiasStep
from tests.proof.plant.effects.outside import Telegraph
from tests.proof.plant.rough.forms import FORMS, KNOWN
from tests.proof.plant.rough.play import BY_SIZE, at_standing, play, standing, without
from tests.proof.plant.rough.runs import Encoder, RoughCase, Run, Tracking
from tests.proof.plant.simulate import seal, write
from tests.proof.study import (
    EVIDENCE,
    Minutes,
    Out,
    Seed,
    Short,
    Write,
    answers,
    folder_of,
    publish,
    table,
)
from tests.proof.trial.blind import RECORDINGS, UNNAMED
from tests.proof.trial.evidence import counting, rate_words
from tests.proof.trial.parameters import Compared, Truth, compared
from tests.proof.trial.seal import SEALED, check_seals, sealed

Kind = Literal["control", "listed", "form", "logger", "outside", "mixed"]
Ask = tuple[Kind, tuple[str, ...], Run | None]

STANDINGS = (40.0, 100.0, 300.0)  # z asked of a listed effect, above everything else
OUTSIDE_STANDINGS = (100.0, 300.0)  # of each of several outside the catalogue
DEGREE = float(np.pi / 180.0)
RUNS: tuple[Run, ...] = ("hand", "shaft", "table")

ANYWHERE = (
    "gyro_scale_nonlinearity", "gyro_scale_asymmetry", "gyro_g2_sensitivity",
    "gyro_scale_g_dependence", "gyro_angular_acceleration", "accel_nonlinearity",
    "temperature_bias", "temperature_scale", "thermal_transient", "thermal_gradient", "bandwidth",
    "coarse_quantisation", "mains_pickup", "hysteresis", "bias_step", "bias_random_walk",
    "accel_axis_skew", "clock_skew", "dropped_samples",
)  # fmt: skip
TURNED = ("time_offset", "lever_arm", "axis_tilt", "structural_compliance", "table_scale")
ON_TABLE = (
    "size_effect", "encoder_eccentricity", "gyro_saturation", "accel_saturation",
    "magnetic_sensitivity", "supply_sensitivity", "vibration_rectification",
)  # fmt: skip
LOGGER = tuple(
    form for form in FORMS
    if form.startswith(("range", "axis", "dead", "code", "repeated", "timestamp"))
)  # fmt: skip
OTHER_FORMS = tuple(form for form in FORMS if form not in LOGGER and not form.startswith("x_"))
OUTSIDE = (
    "x_gain_drift", "x_loose_board", "x_rubber_mount", "x_drive_leak", "x_rate_product",
    "x_accel_cross_quadratic", "x_beat_line", "x_telegraph", "x_bursts", "x_rate_heating",
)  # fmt: skip
OUTSIDE_TURNED = ("x_backlash", "x_stick_slip", "x_cable_drag", "x_third_harmonic")
OUTSIDE_OF: dict[Run, tuple[str, ...]] = {
    "hand": OUTSIDE,
    "shaft": (*OUTSIDE, *OUTSIDE_TURNED, "x_rig_mode"),
    "table": (*OUTSIDE, *OUTSIDE_TURNED, "x_stress_relaxation"),
}
NEEDS_THERMOMETER = (
    "temperature_bias", "temperature_scale", "thermal_gradient", "temperature_bias_late"
)  # fmt: skip


class RoughDrawn(Data):
    """A rough case as drawn. z: asked of each listed effect, above everything else."""

    number: int
    kind: Kind
    rough: RoughCase
    z: float

    @property
    def label(self) -> str:
        """“0007”, the name of its folders: it tells nothing."""
        return f"{self.number:04d}"


def draw_rough(seed: int, short: bool = False) -> list[RoughDrawn]:
    """The cases of a rough trial, in an order that tells nothing."""
    rng = np.random.default_rng([seed, 12])
    asked = list(_short(rng) if short else _full())
    order = rng.permutation(len(asked))
    return [
        RoughDrawn(
            number=n,
            kind=asked[i][0],
            rough=rough_conditions(rng, asked[i]),
            z=float(rng.choice(STANDINGS)),
        )
        for n, i in enumerate(order, start=1)
    ]


def _full() -> Iterator[Ask]:
    for run in RUNS:
        yield from (("control", (), run) for _ in range(14))
        yield from (("outside", (), run) for _ in range(12))
    for name in (*ANYWHERE, *TURNED, *ON_TABLE):
        yield "listed", (name,), None
    for name in OTHER_FORMS:
        yield from (("form", (name,), None) for _ in range(2))
    for name in LOGGER:
        yield from (("logger", (name,), run) for run in RUNS)
    for name in (*ANYWHERE, *LOGGER):
        yield "mixed", (name,), None


def _short(rng: np.random.Generator) -> Iterator[Ask]:
    """A few of each kind, spread over runs and effects."""
    for run in RUNS:
        yield from (("control", (), run) for _ in range(2))
        yield "outside", (), run
    spread: tuple[tuple[Kind, tuple[str, ...], int], ...] = (
        ("listed", (*ANYWHERE, *TURNED, *ON_TABLE), 5), ("form", OTHER_FORMS, 4),
        ("logger", LOGGER, 3), ("mixed", (*ANYWHERE, *LOGGER), 3),
    )  # fmt: skip
    for kind, names, count in spread:
        yield from ((kind, (str(name),), None) for name in rng.choice(names, count, replace=False))


def rough_conditions(rng: np.random.Generator, ask: Ask) -> RoughCase:
    """A case with these effects at typical size; strong ones outside the catalogue are drawn."""
    kind, listed, run = ask
    run = run or _run_for(rng, listed)
    others: tuple[str, ...] = ()
    if kind in ("outside", "mixed"):
        count = int(rng.integers(2, 4)) if kind == "outside" else int(rng.integers(1, 3))
        others = tuple(map(str, rng.choice(OUTSIDE_OF[run], count, replace=False)))
    rate = int(rng.choice([100, 200]))
    declared: dict[str, Any] = {
        "seed": int(rng.integers(1, 1_000_000)),
        "grade": str(rng.choice(["consumer", "industrial"])),
        "rate_hz": rate,
        "latitude_deg": round(float(rng.uniform(-50.0, 60.0)), 2),
        "gravity_m_s2": round(float(rng.uniform(9.781, 9.825)), 4),
        "effects": tuple(EffectCall(name=name) for name in (*others, *listed)),
        "temperature_recorded": bool(set(listed) & set(NEEDS_THERMOMETER) or rng.uniform() < 0.7),
    }
    jitter = float(rng.choice([0.0, 0.0, rng.uniform(1e-4, 1e-3)]))
    if any(name.startswith("timestamp_jitter") for name in listed):
        jitter = 0.0  # one of a kind
    if run == "hand":
        seconds = float(rng.uniform(60.0, 110.0))
        return RoughCase(
            case=Case(**declared), run=run, duration_s=seconds, stamp_jitter=jitter,
            top_rate=float(rng.uniform(3.0, 5.0)), tracking=_tracking(rng, seconds),
        )  # fmt: skip
    if run == "shaft":
        axes = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        return RoughCase(
            case=Case(**declared), run=run, duration_s=float(rng.uniform(60.0, 150.0)),
            stamp_jitter=jitter, axis=axes[int(rng.integers(3))],
            top_rate=float(rng.uniform(1.5, 6.0)), encoder=_encoder(rng, False),
        )  # fmt: skip
    procedure = str(rng.choice(["three_axis", "six_orientations"]))
    declared |= {
        "procedure": procedure,
        "dwell_s": 5.0,
        "rates_deg_s": (float(rng.choice([60, 150])),),
    }
    return RoughCase(
        case=Case(**declared), run=run, stamp_jitter=jitter, encoder=_encoder(rng, True)
    )


def _run_for(rng: np.random.Generator, listed: tuple[str, ...]) -> Run:
    if set(listed) & set(ON_TABLE):
        return "table"
    turned = set(listed) & set(TURNED)
    return RUNS[int(rng.integers(1, 3))] if turned else RUNS[int(rng.integers(3))]


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Evenly drawn in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _encoder(rng: np.random.Generator, speeds: bool) -> Encoder:
    step = _between(rng, 0.01, 0.3) * DEGREE
    return Encoder(
        rate_hz=float(rng.choice([50, 80, 100, 125, 250])),
        step=step,
        noise=float(rng.uniform(0.1, 0.6)) * step,
        jitter=float(rng.choice([0.0, rng.uniform(1e-4, 1e-3)])),
        speeds=speeds and bool(rng.uniform() < 0.5),
    )


def _tracking(rng: np.random.Generator, seconds: float) -> Tracking:
    rate = float(rng.choice([100, 120, 240]))
    turn = _between(rng, 0.1, 3.0) * DEGREE * _direction(rng)
    tilt = float(rng.uniform(0.0, 1.0)) * DEGREE * _direction(rng)
    arm = float(rng.choice([0.0, _between(rng, 2e-3, 5e-2)])) * _direction(rng)
    starts = rng.uniform(5.0, seconds - 5.0, int(rng.integers(0, 4)))
    return Tracking(
        rate_hz=rate,
        position_noise=_between(rng, 5e-5, 5e-4),
        attitude_noise=_between(rng, 0.02, 0.2) * DEGREE,
        turn=tuple(turn.tolist()),
        tilt=(float(tilt[0]), float(tilt[1]), 0.0),
        arm=tuple(arm.tolist()),
        delay=float(rng.choice([0.0, 0.5])) / rate,
        interpolated=bool(rng.uniform() < 0.5),
        gaps=tuple((float(at), float(at + rng.uniform(0.1, 1.0))) for at in np.sort(starts)),
    )


def _direction(rng: np.random.Generator) -> np.ndarray:
    drawn = rng.standard_normal(3)
    return np.asarray(drawn / np.linalg.norm(drawn))


# Rough recordings handed out, their truth sealed elsewhere.


def record_and_seal_rough(drawn: RoughDrawn, folder: Path) -> None:
    """Sizes and plays one case: its recording, and apart from it its truth.

    Writes recordings/<number>/ and sealed/<number>/ with truth.json, truth.parquet and
    trial.json: kind, z asked, and how far each effect stands above everything else.
    """
    rough = drawn.rough
    calls = [call.name for call in rough.case.effects]
    for place, called in enumerate(calls):
        others = rough.without(*calls[place + 1 :])
        outside = KNOWN[called].name.startswith("x_")
        wanted = OUTSIDE_STANDINGS[place % 2] if outside else drawn.z
        sized, _ = at_standing(others, called, wanted)
        rough = rough.with_strength(called, sized.case.effects[place].strength)
    played = play(rough)
    declared = {
        "kind": drawn.kind,
        "asked_z": drawn.z,
        "z": {
            called: standing(played, play(without(rough, called)), called in BY_SIZE)
            for called in calls
        },
    }
    write(played.recording, folder / RECORDINGS / drawn.label)
    sealed = folder / SEALED / drawn.label
    seal(played.recording, played.sealed, played.truth, sealed)
    (sealed / "trial.json").write_text(json.dumps(declared, indent=1), encoding="utf-8")


# Explains rough recordings with the command of an installed engine, each in its own process.
#
# The process gets the folder of one recording and an empty home, and nothing of the trial.

OWN = Path(sys.executable).parent / "mimucal"  # beside the Python that runs the trial
ANSWER, COST, TROUBLE = "answer.json", "seconds.txt", "trouble.txt"
LIMIT = 900.0  # s that one recording may take


def explain_rough(folder: Path, own: Path, engine: Path, minutes: float | None = None) -> None:
    """Answers the recordings of a trial's folder in `own`/<number>/."""
    work = {each.name: each.resolve() for each in sorted((folder / RECORDINGS).iterdir())}
    answers(own.name, work, partial(_answered, own, engine), folder, minutes=minutes)


def _answered(own: Path, engine: Path, recording: Path) -> None:
    folder = own / recording.name
    folder.mkdir(parents=True, exist_ok=True)
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as home:
        surroundings = os.environ | {"MIMUCAL_HOME": home, "OPENBLAS_NUM_THREADS": "1"}
        surroundings.pop("PYTHONPATH", None)  # or another checkout's command would run this code
        try:
            done = subprocess.run(
                [engine, "explain", recording, "--json"],
                env=surroundings, cwd=home, capture_output=True, text=True, timeout=LIMIT,
            )  # fmt: skip
            response, trouble = done.stdout if done.returncode == 0 else "", done.stderr
        except subprocess.TimeoutExpired:
            response, trouble = "", f"no answer within {LIMIT:.0f} s"
    (folder / ANSWER).write_text(response, encoding="utf-8")
    (folder / TROUBLE).write_text(trouble, encoding="utf-8")
    (folder / COST).write_text(f"{time.perf_counter() - started:.1f}\n", encoding="utf-8")


# Parameters that an engine states of a rough recording, beside the true ones.

SAME_PARAMETERS = ("bias_step_single", "bias_step_moving")  # forms that keep their meaning


def compared_rough(declared: dict[str, Any], named: Sequence[dict[str, Any]]) -> Iterator[Compared]:
    """Those that mean the same in both: of effects in the plain plant's form, or one with the same
    parameters, and of what the reference brings along. Other forms have parameters of their own.
    """
    plain = {
        each["name"]: each["parameters"]
        for each in declared["effects"]
        if each["called"] in (each["name"], *SAME_PARAMETERS)
    }
    true = {name: values for name, values in declared["nuisances"].items() if name not in plain}
    truth = Truth(true | plain, declared["parameters"], declared["case"]["case"])
    for finding in named:
        if finding["effect"] in truth.effects:
            pairs, _ = compared(truth, finding["effect"], finding["parameters"])
            yield from pairs


# Opens the seals of a rough trial and holds each answer against the truth.

PLAIN = 30.0  # z from which a listed effect should be named


@dataclass(frozen=True)
class Listed:
    """A listed effect that was hidden. called: its form. z: how far it stands above all else."""

    called: str
    name: str
    z: float
    named: bool
    in_group: bool


@dataclass(frozen=True)
class RoughScore:
    """One answered recording.

    truth: what was hidden, as called; nuisances: what the reference brings along. wrong: names
    that are neither true nor in a group with a true one; a telegraph signal that jumps once in the
    run is also a bias step; in_group: names that are not true
    themselves but stand in such a group. left_over: χ²/dof after explaining by channel; of an
    engine that does not tell it, that of the segments held out. z of what is outside the catalogue
    is not among `listed`.
    """

    number: str
    kind: str
    run: str
    truth: tuple[str, ...]
    nuisances: tuple[str, ...]
    names: tuple[str, ...]
    wrong: tuple[str, ...]
    in_group: tuple[str, ...]
    listed: tuple[Listed, ...]
    parameters: tuple[Compared, ...]
    left_over: dict[str, float]
    verdict: str
    seconds: float
    failed: str | None

    @property
    def worst_left(self) -> float | None:
        """The largest χ²/dof that stays."""
        return max(self.left_over.values(), default=None)


def score_rough(folder: Path, answers: Path) -> list[RoughScore]:
    """Checks the seals, then scores every answer there is. Raises Unusable for a broken seal."""
    check_seals(folder)
    return [
        _score(folder / SEALED / each.name, each)
        for each in sorted(answers.iterdir())
        if (each / COST).exists()
    ]


def _score(sealed: Path, answers: Path) -> RoughScore:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    response = (answers / ANSWER).read_text(encoding="utf-8")
    failed = None if response else (answers / TROUBLE).read_text(encoding="utf-8").strip()[-300:]
    seconds = float((answers / COST).read_text(encoding="utf-8"))
    answer = json.loads(response) if response else {"findings": []}
    return scored_rough(sealed.name, declared, trial, answer, seconds, failed)


def scored_rough(
    number: str,
    declared: dict[str, Any],
    trial: dict[str, Any],
    answer: dict[str, Any],
    seconds: float,
    failed: str | None = None,
) -> RoughScore:
    """The score from what truth.json, trial.json and the engine's answer say."""
    hidden = {each["called"]: each["name"] for each in declared["effects"]}
    true = {*hidden.values(), *declared["nuisances"], *_also_true(declared["effects"])}
    named = [one for one in answer["findings"] if one["effect"] != UNNAMED]
    false = [one for one in named if one["effect"] not in true]
    stated_of = {name for one in named for name in group_of(one)}
    names = {one["effect"] for one in named}
    return RoughScore(
        number=number,
        kind=trial["kind"],
        run=declared["case"]["run"],
        truth=tuple(hidden),
        nuisances=tuple(declared["nuisances"]),
        names=tuple(one["effect"] for one in answer["findings"]),
        wrong=tuple(one["effect"] for one in false if not group_of(one) & true),
        in_group=tuple(one["effect"] for one in false if group_of(one) & true),
        listed=tuple(
            Listed(called, name, trial["z"][called], name in names, name in stated_of)
            for called, name in hidden.items()
            if not name.startswith("x_")
        ),
        parameters=tuple(compared_rough(declared, named)),
        left_over=_left_over(answer),
        verdict=answer.get("verdict", "failed"),
        seconds=seconds,
        failed=failed,
    )


def _also_true(effects: list[dict[str, Any]]) -> set[str]:
    """Catalogue names of what is outside the catalogue but drawn so that it is one of its effects:
    a telegraph signal that jumps once is a bias that steps.
    """
    telegraphs = (each for each in effects if each["name"] == Telegraph.name)
    return {BiasStep.name for each in telegraphs if len(each["parameters"]["times"]) == 1}


def group_of(finding: dict[str, Any]) -> set[str]:
    """Every name that a finding offers for what it found."""
    others = [*(finding.get("group") or ()), *finding["indistinguishable_from"]]
    return {finding["effect"], *others}


def _left_over(answer: dict[str, Any]) -> dict[str, float]:
    held_out = answer.get("held_out")
    beside = {"held out": held_out["chi2_per_dof_after"]} if held_out else {}
    return answer.get("left_over") or beside


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


# The scores of a rough trial as figures.

COLUMNS = (
    "recordings", "number", "any finding named", "a wrong name", "a wrong name, the right one in "
    "its group", f"named at z ≥ {PLAIN:g}", "or in a group", "95 % intervals", "χ²/dof after",
    "no answer", "seconds",
)  # fmt: skip


def rows_rough(scores: Sequence[RoughScore]) -> list[tuple[str, ...]]:
    """All together, then by run and by kind; in the order of COLUMNS."""
    parts = {
        getattr(each, sort): [one for one in scores if getattr(one, sort) == getattr(each, sort)]
        for sort in ("run", "kind")
        for each in sorted(scores, key=lambda one: str(getattr(one, sort)))
    }
    return [_row("all", scores), *(_row(name, part) for name, part in parts.items())]


def _row(name: str, scores: Sequence[RoughScore]) -> tuple[str, ...]:
    answered = [each for each in scores if each.failed is None]
    plain = [one for each in answered for one in each.listed if one.z >= PLAIN]
    left = [each.worst_left for each in answered if each.worst_left is not None]
    rates = (
        counting(bool(set(each.names) - {UNNAMED}) for each in answered),
        counting(bool(each.wrong) for each in answered),
        counting(bool(each.in_group) for each in answered),
        counting(one.named for one in plain),
        counting(one.named or one.in_group for one in plain),
        counting(pair.inside for each in answered for pair in each.parameters),
    )
    return (
        name,
        f"{len(scores)}",
        *(f"{rate.count}/{rate.of} = {rate_words(rate, True)}" if rate.of else "–"
          for rate in rates),
        f"{median(left):.3g}" if left else "–",
        f"{len(scores) - len(answered)}",
        f"{median(each.seconds for each in scores):.0f}",
    )  # fmt: skip


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


# rough.md: what engines said of the same sealed rough recordings.

RULES = (
    "References err (coarse or late encoders, tracked bodies moved by hand), loggers change rows "
    "and codes, effects come in forms that no term has, and two or three strong ones outside the "
    "catalogue come at once. A wrong name: a name of the catalogue that is neither among what is "
    "hidden or brought along by the reference, nor in a group with such a one; the latter are "
    "counted apart. z: how far an effect stands above everything else in the recording, after the "
    "standard's parameters took their part. Intervals: stated parameters whose 95 % interval "
    "holds the truth, where both mean the same. Rates with Wilson's 95 % interval."
)

Answers = Mapping[str, Sequence[RoughScore]]


def rough_markdown(seed: int, seals: str, answers: Answers) -> str:
    """The page of a trial. answers: the scores by engine."""
    title = f"# The sealed trial on rough recordings, seed {seed}"
    lines = [title, "", RULES, "", f"SHA-256 of the seals: {seals}", ""]
    for engine, scores in answers.items():
        lines += [f"## {engine}", "", *table(COLUMNS, rows_rough(scores)), ""]
        lines += [*table(CASES, cases(scores)), ""]
    return "\n".join(lines)


# Holding a rough trial: drawn, sealed, explained blind by one engine or several, scored.

ANSWERS_OF = "answers-"


def rough(
    seed: Seed = 1, short: Short = False, out: Out = None,
    engine: Annotated[
        Path, typer.Option(metavar="PATH", help="The mimucal command of another checkout; again "
                           "with the same --out, its answers stand beside the others.")
    ] = OWN,
    minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """The sealed trial on rough recordings, in place of the catalogue's.

    Raises Unusable for an engine that is not there, and as `sealed`.
    """
    engine, folder = engine.absolute(), folder_of(f"rough-{seed}", out)
    if not engine.is_file():
        raise Unusable(f"--engine {engine} is not there; name a checkout's .venv/bin/mimucal")
    declared = {"seed": seed, "short": short}
    seals = sealed(folder, declared, draw_rough(seed, short), record_and_seal_rough)
    name = engine.parents[2].name  # the checkout's folder: <name>/.venv/bin/mimucal
    explain_rough(folder, folder / f"{ANSWERS_OF}{name}", engine, minutes)
    by_engine = {
        each.name.removeprefix(ANSWERS_OF): score_rough(folder, each)
        for each in sorted(folder.glob(f"{ANSWERS_OF}*"))
    }
    kept = {name: scores for name, scores in by_engine.items() if scores}
    page = rough_markdown(seed, seals, kept)
    publish("rough", page, folder)
    if write:
        (EVIDENCE / "rough" / f"seed-{seed}.md").write_text(page, encoding="utf-8")
