"""From a fitted model to findings: names, channels, parameters in SI, contributions, a verdict."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from engine_run import GRAVITY, NOISY, RATE, WHITE, motion, noise, observed, read
from explained import explanation, finding, nothing_added

from schemas.recording import Recording, Stream
from tasks.explain.events.codes import CodeFault
from tasks.explain.events.detect import RangeSetting
from tasks.explain.events.event import Events
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.findings import (
    CHANCE,
    JUMPS,
    OF_A_LIMIT,
    _needed,
    _verdict,
    chance_of_largest,
    drift,
    explanation_of,
    with_faults,
)
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import ACCELS, CHANNELS, UNNAMED, Explanation, Finding
from tasks.explain.inputs.blocks import full_rate
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.empirical import SLOW_DRIFT, sinusoid
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.memory import bias_step
from tasks.model.terms.site import earth_rotation
from tasks.motion.pose import Tracking
from tasks.motion.table import EARTH_RATE
from tasks.words import message, say
from tests.manifests import manifest_of

RUN = motion()
ARM = (0.004, -0.006, 0.003)
EARTH = earth_rotation(np.radians(40.0))
VERTICAL = EARTH_RATE * np.sin(np.radians(40.0))


def picked(term: Term, own: tuple[int, ...] | None = None, *rivals: str) -> Selected:
    """A term chosen with a score of 90, and the names that fit as well."""
    own = tuple(range(len(term.parameters))) if own is None else own
    return Selected(Candidate(term, own or (0,), own, 1), 100.0, 90.0, rivals)


def explained(made: np.ndarray, *chosen: Selected) -> Explanation:
    """What is said of readings that chosen terms, one each, are fitted to; rows are the blocks."""
    columns = {name: made[:, c].copy() for c, name in enumerate(CHANNELS)}
    manifest = manifest_of(
        "made",
        {"gravity_m_s2": GRAVITY},
        segments=[{
            "name": "all", "kind": "static", "up": "+z", "t_start": 0.0, "t_end": RUN.t[-1] + 1.0,
        }],
    )  # fmt: skip
    recording = Recording(manifest, Stream(RUN.t, columns))
    # The labels know nothing of the motion, which is put in here.
    full = replace(
        full_rate(recording), motion=RUN, segment_variance=np.tile(WHITE[[0, 3]] ** 2, (2, 1))
    )
    blocks = observed(made, RUN)
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    selection = Selection(chosen, NOISY, 1e-9 if chosen else 0.5, nothing)
    evidence = Evidence.of(FittedSelection.of(selection, blocks, RATE))
    masked = np.zeros(made.shape, bool)
    prepared = Prepared(recording, (), recording, full, full, 0.0, Events((), masked), masked)
    return explanation_of(prepared, evidence)


@pytest.fixture(scope="module")
def arm_and_earth() -> tuple[np.ndarray, Explanation]:
    made = read(RUN, (EARTH, ()), (LEVER_ARM, ARM)) + noise(len(RUN.t), 51, NOISY)
    # A size effect holds a lever arm: the comparison's to judge.
    arm = picked(LEVER_ARM, None, "size_effect", "structural_compliance")
    return made, explained(made, picked(EARTH), arm)


def named(answer: Explanation, effect: str) -> Finding:
    return next(each for each in answer.findings if each.effect == effect)


def test_findings_stand_by_their_gain_and_name_their_channels(
    arm_and_earth: tuple[np.ndarray, Explanation],
) -> None:
    answer = arm_and_earth[1]
    assert [each.effect for each in answer.findings] == ["lever_arm", "earth_rotation"]
    assert answer.findings[0].gain > answer.findings[1].gain > 0
    assert named(answer, "earth_rotation").channels == (0, 1, 2)
    assert set(named(answer, "lever_arm").channels) <= {3, 4, 5}
    assert answer.verdict == "explained"


def test_a_contribution_is_what_the_finding_adds_to_the_readings(
    arm_and_earth: tuple[np.ndarray, Explanation],
) -> None:
    answer = arm_and_earth[1]
    by_arm = read(RUN, (LEVER_ARM, ARM)) - read(RUN)
    text = named(answer, "lever_arm").contribution
    np.testing.assert_allclose(text, by_arm, atol=0.02 * np.abs(by_arm).max())
    by_earth = read(RUN, (EARTH, ())) - read(RUN)
    text = named(answer, "earth_rotation").contribution
    np.testing.assert_allclose(text, by_earth, atol=0.02 * EARTH_RATE)


def test_parameters_are_si_with_their_uncertainty_and_earths_rate_is_as_seen(
    arm_and_earth: tuple[np.ndarray, Explanation],
) -> None:
    answer = arm_and_earth[1]
    for parameter, true in zip(named(answer, "lever_arm").parameters, ARM, strict=True):
        assert parameter.unit == "m"
        assert abs(parameter.value - true) < 3.0 * parameter.u
    (vertical,) = named(answer, "earth_rotation").parameters
    factor = np.degrees(3600.0)
    assert (vertical.name, vertical.unit) == ("vertical_rate", "deg/h")
    assert abs(vertical.value - VERTICAL * factor) < 3.0 * vertical.u
    assert vertical.u < 0.1 * vertical.value


def test_two_steps_are_unnamed_jumps() -> None:
    made = read(RUN) + noise(len(RUN.t), 52, NOISY)
    for at, size in ((100.0, 8.0), (250.0, -6.0)):
        made[RUN.t >= at, 1] += size * WHITE[1]
    later = replace(bias_step(0, 250.0), variant=1)
    answer = explained(made, picked(bias_step(0, 100.0), (1,)), picked(later, (1,)))
    (jumps,) = answer.findings
    assert (jumps.effect, jumps.family, jumps.channels) == (UNNAMED, UNNAMED, (1,))
    assert jumps.follows == jumps.title == JUMPS
    assert jumps.indistinguishable == ()
    assert answer.verdict == "unexplained"
    times = [each.value for each in jumps.parameters if each.name == "time"]
    assert times == pytest.approx([100.0, 250.0], abs=1.0 / RATE)
    sizes = [each.value / WHITE[1] for each in jumps.parameters if each.name == "gyro_y"]
    assert sizes == pytest.approx([8.0, -6.0], abs=1.0)


def test_a_name_beside_what_has_none_explains_in_part() -> None:
    swing = sinusoid(ACCELS).shaped((40.0,))
    sizes = 3.0 * np.repeat(WHITE[3:], 2)
    warming = (2e-5, 0.0, -2e-5, 0.0, 8e-4, 0.0)
    made = read(RUN, (swing, sizes), (TEMPERATURE_BIAS, warming)) + noise(len(RUN.t), 53, NOISY)
    answer = explained(made, picked(swing.shaped((40.3,))), picked(TEMPERATURE_BIAS))
    assert answer.verdict == "partly_explained"
    found = named(answer, UNNAMED)
    assert found.follows is not None
    assert "period" in say(found.follows, "en")
    period = next(each for each in found.parameters if each.name == "period")
    assert abs(period.value - 40.0) < 3.0 * period.u
    units = {each.name: each.unit for each in named(answer, "temperature_bias").parameters}
    assert units["gyro_x"] == "(rad/s)/K"
    assert units["accel_x"] == "(m/s2)/K"


def test_where_nothing_was_chosen_nothing_is_said() -> None:
    answer = explained(read(RUN) + noise(len(RUN.t), 54, NOISY))
    assert (answer.findings, answer.verdict) == ((), "no_mismatch")
    np.testing.assert_allclose(answer.found, answer.nominal, atol=1e-12)


@pytest.mark.parametrize(("of_reference", "verdict"), [(0.5, "no_mismatch"), (0.0, "unexplained")])
def test_what_the_references_own_errors_may_leave_is_no_mismatch(
    of_reference: float, verdict: str
) -> None:
    """Nothing above chance, and 2.3 times the noise is left; of_reference: of the noise."""
    squares, none = np.full((100, 6), 2.3), np.zeros((100, 6), bool)
    noise = np.ones((100, 6))
    left = LeftOver(squares, squares, none, noise, of_reference * noise, 1, np.zeros(6))
    assert _verdict((), 1.0, left) == verdict


@pytest.mark.parametrize("channel", range(6))
@pytest.mark.parametrize(("left_in", "verdict"), [(1.6, "explained"), (2.4, "partly_explained"),
                                                  (3e5, "partly_explained")])  # fmt: skip
def test_nothing_is_explained_while_more_than_noise_is_left_in_a_channel(
    left_in: float, verdict: str, channel: int
) -> None:
    """Whatever share of the mismatch was removed: 99.9 % of it."""
    after, none = np.ones((100, 6)), np.zeros((100, 6), bool)
    after[:, channel] = left_in
    left = LeftOver(1000.0 * after, after, none, np.ones((100, 6)), none * 1.0, 1, np.zeros(6))
    assert left.explained_share > 0.99
    named = Finding("lever_arm", "geometry", "", "", "", (channel,), (), after, 1e5, 1e5, 1e4)
    assert _verdict((named,), 0.0, left) == verdict
    assert _verdict((replace(named, effect=UNNAMED),), 0.0, left) == "unexplained"


# A drift states its size; a walk walks throughout, no faster than units do, in the unit.


def test_walks_are_said_to_switch_as_seldom_as_stated() -> None:
    rng = np.random.default_rng(17)
    walks = np.cumsum(rng.standard_normal((2000, 400)), axis=1)
    switching = sum(chance_of_largest(walk) < CHANCE for walk in walks)
    assert switching <= CHANCE * len(walks) + 3.0 * np.sqrt(CHANCE * len(walks))


def test_a_signal_that_switches_there_and_back_is_no_walk() -> None:
    t = np.linspace(0.0, 100.0, 5000)
    switched = np.where((t > 36.8) & (t < 61.3), 1.0, 0.0)
    assert chance_of_largest(switched) < 1e-6
    wander = 0.05 * np.cumsum(np.random.default_rng(3).standard_normal(5000)) / np.sqrt(250.0)
    assert chance_of_largest(switched + wander) < CHANCE


def walk(rates: dict[int, float], seed: int = 5) -> Finding:
    """A random walk of q (per √s) in some channels, throughout the run."""
    rng, step = np.random.default_rng(seed), float(RUN.t[1] - RUN.t[0])
    course = np.zeros((len(RUN.t), 6))
    for channel, rate in rates.items():
        course[:, channel] = rate * np.sqrt(step) * np.cumsum(rng.standard_normal(len(RUN.t)))
    return Finding(
        effect="bias_random_walk", family="memory", title="wanders", equation="", source="",
        channels=tuple(rates), parameters=(), contribution=course, gain=500.0, delta_bic=450.0,
        held_out_gain=100.0, terms=(("bias_random_walk", 3),), behaviour="a slow drift",
    )  # fmt: skip


@pytest.mark.parametrize("rates", [{0: 6e-6, 4: 8e-5}, {1: 2e-4}, {0: 1e-5, 1: 1e-5, 2: 1e-5}])
def test_a_drift_states_how_far_and_how_fast_it_wanders(rates: dict[int, float]) -> None:
    one = walk(rates)
    sized = drift(one, RUN)
    assert sized.effect == "bias_random_walk"
    stated = {p.name: p for p in sized.parameters}
    for channel, rate in rates.items():
        rms, wander = (stated[f"{name}_{CHANNELS[channel]}"] for name in ("rms", "rate"))
        assert rms.value == pytest.approx(one.contribution[:, channel].std())
        assert abs(wander.value - rate) < 3.0 * wander.u
        assert wander.unit == ("(rad/s)/sqrt(s)" if channel < 3 else "(m/s2)/sqrt(s)")
    unnamed = replace(one, effect=UNNAMED, title=SLOW_DRIFT)
    assert drift(unnamed, RUN).parameters == sized.parameters


@pytest.mark.parametrize(
    ("rates", "furthest"),
    [({3: 0.06}, "rate_accel_x"), ({2: 4e-3}, "rate_gyro_z"), ({0: 1e-5, 4: 0.05}, "rate_accel_y")],
)
def test_what_wanders_faster_than_any_unit_is_no_walk_of_one(
    rates: dict[int, float], furthest: str
) -> None:
    lost = drift(walk(rates), RUN)
    assert (lost.effect, lost.title) == (UNNAMED, "a slow drift")
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.parameter) == ("implausible", furthest)
    assert lost.parameters


def level(amplitude: float, seconds: float) -> Finding:
    """What a slow error of the attitude about one axis of the body makes of gravity."""
    error = amplitude * np.sin(2.0 * np.pi * RUN.t / seconds)[:, None] * np.array([0.3, 0.5, 0.8])
    course = np.hstack([np.zeros((len(RUN.t), 3)), 9.8 * np.cross(error, RUN.up)])
    return replace(walk({3: 1.0, 4: 1.0, 5: 1.0}), contribution=course)


@pytest.mark.parametrize(("amplitude", "seconds"), [(1e-3, 70.0), (2e-3, 130.0), (5e-4, 300.0)])
def test_what_a_slow_error_of_the_references_attitude_would_do_is_not_the_units(
    amplitude: float, seconds: float
) -> None:
    by_poses = replace(RUN, tracking=Tracking(1.0, 1.0, 0.01, 1e-12, 1e-14))
    lost = drift(level(amplitude, seconds), by_poses)
    assert lost.refusal is not None
    assert (lost.effect, lost.refusal.kind) == (UNNAMED, "reference_noise")
    assert drift(walk({3: 8e-5, 4: 8e-5, 5: 8e-5}), by_poses).effect == "bias_random_walk"
    assert drift(walk({0: 6e-6, 4: 8e-5}), by_poses).effect == "bias_random_walk"
    assert drift(level(amplitude, seconds), RUN).effect == "bias_random_walk"  # by no reference


# How clear an event must be to be a finding.


def needed(effect: str, left: list[float]) -> float:
    event = SimpleNamespace(effect=effect, channels=(3, 4))
    return _needed(cast(Any, event), cast(Any, SimpleNamespace(chi2_per_degree=np.array(left))))


@pytest.mark.parametrize("effect", ["gyro_saturation", "accel_saturation"])
def test_a_limit_must_be_clear_of_what_is_left_in_its_channels(effect: str) -> None:
    quiet = [1.0, 1.0, 1.0, 0.8, 0.9, 50.0]
    assert needed(effect, quiet) == OF_A_LIMIT
    assert needed(effect, [1.0, 1.0, 1.0, 9.0, 11.0, 1.0]) == pytest.approx(10.0 * OF_A_LIMIT)
    assert needed(effect, [np.nan] * 6) == OF_A_LIMIT


def faulty(ideal_run: Any, *faults: Any, beside: float) -> Explanation:
    """An explanation with a step of some size in accelerometer x, of a run that had faults."""
    run = ideal_run(dwell=4.0)
    step = nothing_added(run)
    step[: len(step) // 2, 3] = beside
    found = (finding(step, share=0.8),) if beside else ()
    answer = explanation(run, *found)
    answer = replace(answer, explained_share=0.8 if beside else 0.0)
    removed = float(((step / answer.noise) ** 2).sum())  # 0.8 of the mismatch that is left
    left = SimpleNamespace(removed=removed, remaining=0.25 * removed)
    prepared = SimpleNamespace(recorded=run, faults=faults)
    return with_faults(answer, cast(Any, prepared), cast(Any, left))


def wrong_codes(rows: int, size: float) -> CodeFault:
    off = np.zeros((rows, 6))
    off[: rows // 2, 0] = size
    return CodeFault("code_fault", (0,), (), 1e-20, message("events-constant", channels=""), off)


def test_a_setting_has_no_share_of_what_the_others_leave(ideal_run: Any) -> None:
    setting = RangeSetting(
        "range_setting", (3, 4, 5), (), 1e-20, message("events-constant", channels=""), 1, 2.0
    )
    first, step = faulty(ideal_run, setting, beside=0.1).findings
    assert (first.effect, first.share, first.held_out_gain) == ("range_setting", 0.0, 0.0)
    assert step.share == pytest.approx(0.8)
    alone = faulty(ideal_run, setting, beside=0.0)
    assert (alone.explained_share, alone.findings[0].share) == (1.0, 0.0)


def test_wrong_codes_share_the_mismatch_with_what_is_beside_them(ideal_run: Any) -> None:
    rows = len(ideal_run(dwell=4.0).imu.t)
    answer = faulty(ideal_run, wrong_codes(rows, 0.1), beside=0.1)
    first, step = answer.findings  # as large: of 1 + 1/0.8 the one is 1, the other 0.8 of the rest
    assert first.share == pytest.approx(1.0 / 2.25)
    assert step.share == pytest.approx(1.0 / 2.25)
    assert answer.explained_share == pytest.approx(first.share + step.share)
    alone = faulty(ideal_run, wrong_codes(rows, 0.1), beside=0.0)
    assert alone.findings[0].share == pytest.approx(1.0)
