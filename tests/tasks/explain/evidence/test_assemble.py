"""From a fitted model to findings: names, channels, parameters in SI, contributions, a verdict."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import GRAVITY, NOISY, RATE, WHITE, motion, noise, observed, read

from schemas.recording import Recording, Stream
from tasks.explain.channels import ACCELS, CHANNELS
from tasks.explain.events.event import Events
from tasks.explain.evidence.assemble import _verdict, explanation_of
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.findings import JUMPS
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Explanation, Finding
from tasks.explain.inputs.full_rate import full_rate
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.empirical_terms import sinusoid
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.memory import bias_step
from tasks.model.terms.site import earth_rotation
from tasks.motion.table import EARTH_RATE
from tasks.words import say
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
