"""Opens the seals and holds each answer against the truth."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO
from schemas.tolerance import Verdict
from tasks.validation.coverage import interval_of_share
from tests.proof.plant.case import channel_noise
from tests.proof.trial.blind import ANSWER, ANSWERS, CERTIFICATE, PREDICTION, UNNAMED
from tests.proof.trial.parameters import Compared, Truth, compared, freedom_of
from tests.proof.trial.seal import ABSORBED, SEALED, check_seals

# What it costs to miss the physics: how wrong the certificate is without it and with it found.

LIMIT = 4.0  # of U: the tightest limits that a test accuracy of 4 to 1 lets anybody judge by
SPREAD = LIMIT / 3.0  # of U: standard deviation of what a unit's values changed by in its service

Values = Mapping[str, tuple[float, float]]  # value and U by item and element


@dataclass(frozen=True)
class Cost:
    """One case's certificates, beside that of the same run and noise without the effects.

    before, after: the largest error of a value in its own stated U, as the clauses give it and
    with the findings taken off; worst: which one it is before. conforms: whether the unit that is
    judged conforms; passed_before, passed_after: whether its certificate says so. unnoticed: the
    clauses' own evaluation remarks on no more residuals than it does without the effects.
    """

    before: float
    after: float
    worst: str
    conforms: bool
    verdict_before: Verdict
    verdict_after: Verdict
    unnoticed: bool

    @property
    def wrong_before(self) -> bool:
        """Passed and does not conform, or the other way round; to leave it open is not wrong."""
        return self.verdict_before == ("fail" if self.conforms else "pass")

    @property
    def wrong_after(self) -> bool:
        return self.verdict_after == ("fail" if self.conforms else "pass")


def cost_of(
    clean: Mapping[str, Any] | None,
    read: Mapping[str, Any] | None,
    less: Mapping[str, Any] | None,
    seed: int,
) -> Cost | None:
    """From the certificates without effects, as read, and less what was found (None: nothing was).

    The verdict is that of a recalibration: each value may differ by 4 U (of the clean run) at
    most from the last certificate's. The unit's own change since then is drawn for each value from
    N(0, (4 U/3)²), so that nine units of ten conform; what the effects add goes on top. A value
    whose U has grown beyond the limits is left open.
    None where there is no certificate, or no value that all of them state.
    """
    if clean is None or read is None:
        return None
    true, shown = clean["values"], read["values"]
    mended = shown if less is None else less["values"]
    common = [name for name in true if name in shown and name in mended]
    if not common:
        return None
    before, after = (_errors(true, response, common) for response in (shown, mended))
    known, own = np.array([true[name] for name in common]).T
    changed = np.random.default_rng([seed, 11]).normal(0.0, SPREAD, len(common))

    def judged(response: Values) -> Verdict:
        value, U = np.array([response[name] for name in common]).T
        return _verdict(changed + (value - known) / own, U / own)

    return Cost(
        before=float(before.max()),
        after=float(after.max()),
        worst=common[int(before.argmax())],
        conforms=bool((np.abs(changed) <= LIMIT).all()),
        verdict_before=judged(shown),
        verdict_after=judged(mended),
        unnoticed=read["scatter"] <= clean["scatter"],
    )


def _verdict(moved: np.ndarray, U: np.ndarray) -> Verdict:
    """On changes and U (n,), both in U of the clean run; by JCGM 106 without a guard band.

    A U beyond the limits leaves a value open, unless all of value ± U lies outside.
    """
    outside, open_ = np.abs(moved) > LIMIT, U > LIMIT
    if (outside & ~open_).any() or (np.abs(moved) - U > LIMIT).any():
        return "fail"
    return "inconclusive" if open_.any() else "pass"


def _errors(true: Values, response: Values, names: list[str]) -> np.ndarray:
    """|stated − true|/U of each value."""
    return np.array([abs(response[name][0] - true[name][0]) / response[name][1] for name in names])


@dataclass(frozen=True)
class Gap:
    """Misfits to the noise-free truth, Σ|…|²/σ², σ the white noise of the grade.

    first: of the standard's model, fitted. left: with the findings. floor: what noise alone makes
    of the standard's parameters.
    """

    first: float
    left: float
    floor: float

    @property
    def closed(self) -> float:
        """1 − Σ|truth − found|²/σ² / Σ|truth − nominal|²/σ²."""
        return 1.0 - self.left / self.first

    @property
    def of_closable(self) -> float | None:
        """What was closed, of what the noise lets be closed; None where that is nothing."""
        closable = self.first - self.floor
        return (self.first - self.left) / closable if closable > 0.0 else None


@dataclass(frozen=True)
class Score:
    """What one answer is worth.

    z, concealment, freedom (how many numbers its form leaves open): of each true effect.
    names: of the findings, in their order, `unnamed` among them. A name's twins are what its
    finding lists as indistinguishable from it.
    right: the first name is a true one. right_or_twin: it or one of its twins is.
    wrong: names that are not true; wrong_beyond_twins: of them those without a true twin.
    cost: what missing it costs, None where the clauses give no item. gap: None for clean cases
    and failures. parameters: of effects named rightly.
    """

    number: str
    kind: str
    effects: tuple[str, ...]
    asked_z: float | None
    z: dict[str, float]
    concealment: dict[str, float]
    freedom: dict[str, int]
    conditions: dict[str, Any]
    verdict: str
    names: tuple[str, ...]
    right: bool
    right_or_twin: bool
    wrong: tuple[str, ...]
    wrong_beyond_twins: tuple[str, ...]
    cost: Cost | None
    gap: Gap | None
    parameters: tuple[Compared, ...]
    uncompared: tuple[str, ...]
    seconds: float
    failed: str | None

    @property
    def detected(self) -> bool:
        return bool(self.names)

    @property
    def abstained(self) -> bool:
        """Found, and left without a name."""
        return self.detected and all(name == UNNAMED for name in self.names)

    @property
    def named(self) -> tuple[str, ...]:
        """The true effects that were named."""
        return tuple(effect for effect in self.effects if effect in self.names)

    @property
    def can_be_determined(self) -> bool:
        """Whether the data show it at all: the standard absorbs another gravity whole."""
        return self.effects != (ABSORBED,)

    @property
    def has_a_name(self) -> bool:
        """Whether a name of the catalogue would be right."""
        return self.can_be_determined and any(not e.startswith("x_") for e in self.effects)


def score_all(folder: Path) -> list[Score]:
    """Checks the seals, then scores every answer. Raises Unusable for a broken seal."""
    check_seals(folder)
    return [score(folder, each.name) for each in sorted((folder / SEALED).iterdir())]


def score(folder: Path, number: str) -> Score:
    """One answer against its truth."""
    sealed, answers = folder / SEALED / number, folder / ANSWERS / number
    declared = _json(sealed / "truth.json")
    answer = _json(answers / ANSWER)
    trial, stated, gap = _json(sealed / "trial.json"), _json(answers / CERTIFICATE), None
    if declared["effects"] and "failed" not in answer:
        first, left = misfits(sealed / "truth.parquet", answers / PREDICTION, declared["case"])
        gap = Gap(first, left, trial["floor"])
    seed = declared["case"]["seed"]
    cost = cost_of(trial["certificate"], stated["read"], stated["less"], seed)
    if "failed" in stated:
        answer.setdefault("failed", f"calibrate --terms: {stated['failed']}")
    return scored(number, declared, trial, answer, gap, cost)


def scored(
    number: str,
    declared: dict[str, Any],
    trial: dict[str, Any],
    answer: dict[str, Any],
    gap: Gap | None,
    cost: Cost | None = None,
) -> Score:
    """The score from what truth.json, trial.json and answer.json say."""
    case, effects = declared["case"], tuple(declared["effects"])
    findings = answer.get("findings", [])
    named = [one for one in findings if one["effect"] != UNNAMED]
    wrong = [one for one in named if one["effect"] not in effects]
    truth = Truth(declared["effects"], declared["parameters"], case)
    beside = [
        compared(truth, one["effect"], one["parameters"])
        for one in named
        if one["effect"] in effects
    ]
    shown = ("grade", "procedure", "rate_hz", "rates_deg_s", "dwell_s", "order", "climate",
             "latitude_deg", "heading_deg", "temperature_recorded", "site_known")  # fmt: skip
    return Score(
        number=number,
        kind=trial["kind"],
        effects=effects,
        asked_z=trial["asked_z"],
        z=trial["z"],
        concealment=trial["concealment"],
        freedom={effect: freedom_of(truth, effect) for effect in effects},
        conditions={name: case[name] for name in shown},
        verdict=answer.get("verdict", "failed"),
        names=tuple(one["effect"] for one in findings),
        right=bool(named) and named[0]["effect"] in effects,
        right_or_twin=bool(named) and _true_or_twin(named[0], effects),
        wrong=tuple(one["effect"] for one in wrong),
        wrong_beyond_twins=tuple(one["effect"] for one in wrong if not _true_or_twin(one, effects)),
        cost=cost,
        gap=gap,
        parameters=tuple(pair for pairs, _ in beside for pair in pairs),
        uncompared=tuple(name for _, alone in beside for name in alone),
        seconds=answer["seconds"],
        failed=answer.get("failed"),
    )


def _true_or_twin(finding: dict[str, Any], effects: tuple[str, ...]) -> bool:
    return not {finding["effect"], *finding["indistinguishable_from"]}.isdisjoint(effects)


def misfits(truth: Path, prediction: Path, case: dict[str, Any]) -> tuple[float, float]:
    """Σ|truth − nominal|²/σ² and Σ|truth − found|²/σ² over the rows where both are known."""
    true, response = pq.read_table(truth), pq.read_table(prediction)
    left = first = 0.0
    for channel, noise in zip(GYRO + ACCEL, channel_noise(case["grade"]), strict=True):
        sigma = noise.white * np.sqrt(case["rate_hz"] / 2.0)
        series = true[channel].to_numpy()
        found, nominal = (
            (series - response[f"{channel}_{which}"].to_numpy()) / sigma
            for which in ("found", "nominal")
        )
        known = np.isfinite(found) & np.isfinite(nominal)
        left += float(found[known] @ found[known])
        first += float(nominal[known] @ nominal[known])
    return first, left


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


# The scores as figures: rates with their Wilson intervals, by effect and z, and in all.


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


@dataclass(frozen=True)
class Row:
    """Cases of one kind. parameters: intervals that hold the truth; gap: the median share
    closed; of_closable: that of what noise lets be closed. right: of those that have a name.
    before, after: median of the certificate's largest error, in U, without the findings and with
    them; wrong_before, wrong_after: verdicts that are not the unit's; unnoticed: certificates whose
    own evaluation remarks on nothing.
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
    before: float | None
    after: float | None
    before_most: float | None
    wrong_before: Rate
    wrong_after: Rate
    unnoticed: Rate
    of_closable: float | None


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
        before=median(each.before for each in costs) if costs else None,
        after=median(each.after for each in costs) if costs else None,
        before_most=max((each.before for each in costs), default=None),
        wrong_before=of_costs(lambda each: each.wrong_before),
        wrong_after=of_costs(lambda each: each.wrong_after),
        unnoticed=of_costs(lambda each: each.unnoticed),
        of_closable=median(shares) if shares else None,
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
