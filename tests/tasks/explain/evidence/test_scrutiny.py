"""A name stands where its parameters are the same everywhere, and every channel is the better."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from engine_run import MOVE, NOISY, REST, motion, noise, read, selected

from tasks.explain.evidence.evidence import Evidence, pruned
from tasks.explain.evidence.scrutiny import Examined, Scrutiny, _made_by_placing, _undetermined
from tasks.model.term import Term
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
ARM = np.array([0.04, -0.06, 0.03])
FIRST_HALF = (RUN.t < 0.5 * RUN.t[-1])[:, None]
TRIED = 300


def scrutinised(made: np.ndarray, *terms: Term) -> list[Scrutiny]:
    evidence = Evidence.of(selected(made, *terms))
    return [Scrutiny.of(evidence, number) for number in range(len(terms))]


def arms(first: np.ndarray, second: np.ndarray, seed: int = 51) -> np.ndarray:
    """Readings of a lever arm that is another in the second half."""
    made = np.where(FIRST_HALF, read(RUN, (LEVER_ARM, first)), read(RUN, (LEVER_ARM, second)))
    return made + noise(len(RUN.t), seed, NOISY)


@pytest.mark.parametrize("seed", range(2))
def test_a_law_that_is_there_keeps_its_name_and_its_u(seed: int) -> None:
    made = arms(ARM, ARM, seed)
    (one,) = scrutinised(made, LEVER_ARM)
    assert one.refusal is None
    assert one.homogeneity_p is not None
    assert one.homogeneity_p > 1e-3
    model = selected(made, LEVER_ARM).model
    assert one.u == pytest.approx(model.u[model.places[LEVER_ARM.key]], rel=0.1)


def test_what_is_another_in_each_half_is_not_one_law() -> None:
    (one,) = scrutinised(arms(ARM, -ARM), LEVER_ARM)
    assert one.homogeneity_p is not None
    assert one.homogeneity_p < 1e-6
    assert one.refusal is not None
    assert (one.refusal.kind, one.refusal.name) == ("inhomogeneous", "lever_arm")
    k = ["r_x", "r_y", "r_z"].index(one.refusal.parameter or "")
    assert one.refusal.smallest == pytest.approx(-abs(ARM[k]), rel=0.2)
    assert one.refusal.largest == pytest.approx(abs(ARM[k]), rel=0.2)


def test_parts_that_differ_by_little_are_one_law_whose_u_covers_them() -> None:
    """Two per cent, at so high a signal that the parts are told apart without any doubt."""
    long = 4.0 * ARM
    (one,) = scrutinised(arms(1.02 * long, 0.98 * long), LEVER_ARM)
    assert one.homogeneity_p is not None
    assert one.homogeneity_p < 1e-6
    assert one.refusal is None
    assert (2.0 * one.u > 0.02 * np.abs(long)).all()


def test_a_channel_that_gets_worse_takes_the_name_away() -> None:
    """A delay of the gyros alone: no delay of the unit, whose accelerometers would share it."""
    late = read(RUN, (TIME_OFFSET, [0.02]))
    made = read(RUN)
    made[:, :3] = late[:, :3]
    (one,) = scrutinised(made + noise(len(RUN.t), 52, NOISY), TIME_OFFSET)
    assert one.refusal is not None
    assert one.refusal.kind in ("channel_worse", "inhomogeneous")
    (true,) = scrutinised(late + noise(len(RUN.t), 52, NOISY), TIME_OFFSET)
    assert true.refusal is None


@pytest.mark.parametrize(("beyond", "refused"), [(1.0, False), (6.0, True)])
def test_a_size_is_implausible_where_its_whole_interval_is(beyond: float, refused: bool) -> None:
    """beyond: standard uncertainties between the estimate and the end of the range."""
    made = arms(ARM, ARM)
    model, place = selected(made, LEVER_ARM).model, 1
    estimates = model.values[model.places[LEVER_ARM.key]]
    u = model.u[model.places[LEVER_ARM.key]]
    end = float(abs(estimates[place]) - beyond * u[place])
    narrow = [replace(one, plausible=(-end, end)) if k == place else one
              for k, one in enumerate(LEVER_ARM.parameters)]  # fmt: skip
    (one,) = scrutinised(made, replace(LEVER_ARM, parameters=tuple(narrow)))
    assert (one.refusal is not None and one.refusal.kind == "implausible") == refused


@pytest.mark.parametrize(("correlation", "refused"), [(0.0, True), (-0.99, False)])
def test_what_all_parameters_together_determine_has_a_name(
    correlation: float, refused: bool
) -> None:
    values, u = np.array([1.0, 1.0]), np.array([1.0, 1.0])  # each less than its U, of two
    evidence: Any = SimpleNamespace(
        groups=[SimpleNamespace(name=LEVER_ARM.name)],
        parameters=lambda _: LEVER_ARM.parameters[:2],
        correlation=lambda _: np.array([[1.0, correlation], [correlation, 1.0]]),
    )
    refusal = _undetermined(Examined(cast(Evidence, evidence), 0, values, u))
    assert (refusal is not None and refusal.kind == "undetermined") == refused


def rough(seed: int) -> np.ndarray:
    """Offsets of each stretch that no term of the model follows, a hundred times the noise."""
    rng = np.random.default_rng(seed)
    stretch = (RUN.t // (REST + MOVE)).astype(int)
    levels = rng.standard_normal((int(stretch[-1]) + 1, 6)) * np.repeat([2e-3, 5e-2], 3)
    return levels[stretch] * np.sin(RUN.t)[:, None]


@pytest.mark.parametrize("seed", range(2))
def test_what_does_not_stand_out_of_what_is_left_goes(seed: int) -> None:
    """Each would be strong evidence beside the noise of the sensor alone."""
    made = read(RUN) + rough(seed) + noise(len(RUN.t), 53, NOISY)
    fit = selected(made, STRUCTURAL_COMPLIANCE, LEVER_ARM)
    evidence = Evidence.of(fit)
    assert max(evidence.gain(0), evidence.gain(1)) > 100.0
    left = pruned(fit, TRIED)
    assert left.groups == ()
    assert left.fit.selection.p_value > 0.005


@pytest.mark.rehearsal
def test_what_stands_out_of_what_is_left_stays_and_its_interval_holds_the_truth() -> None:
    inside = []
    for seed in range(8):
        made = read(RUN, (LEVER_ARM, 3.0 * ARM)) + rough(seed) + noise(len(RUN.t), 54, NOISY)
        evidence = pruned(selected(made, LEVER_ARM), TRIED)
        assert [group.name for group in evidence.groups] == ["lever_arm"]
        one = Scrutiny.of(evidence, 0)
        inside += (np.abs(evidence.values[evidence.own[0]] - 3.0 * ARM) < 2.0 * one.u).tolist()
    assert np.mean(inside) > 0.85


def placed(rests: int, term: Term, parameters: int = 6, **motion: Any) -> Examined:
    """A run of rests with a turn after each, told by labels unless `motion` says otherwise."""
    segment = np.tile(np.repeat([0, -1], 20), rests)
    segment[segment == 0] = np.repeat(np.arange(rests), 20)
    rate = np.where(segment[:, None] >= 0, 0.0, 0.3) * np.ones(3)
    fields = {"axes": None, "tracking": None, "rate": rate} | motion
    blocks = SimpleNamespace(motion=SimpleNamespace(**fields), segment=segment)
    evidence = SimpleNamespace(
        fit=SimpleNamespace(blocks=blocks), own=[np.arange(parameters)],
        groups=[SimpleNamespace(terms=(term,), name=term.name)],
    )  # fmt: skip
    return Examined(cast(Evidence, evidence), 0, np.zeros(0), np.zeros(0))


def test_six_labelled_rests_tell_no_fixture_that_bends() -> None:
    refusal = _made_by_placing(placed(6, STRUCTURAL_COMPLIANCE))
    assert refusal is not None
    assert (refusal.kind, refusal.name, refusal.value) == ("placed", "structural_compliance", 6)


@pytest.mark.parametrize(
    ("rests", "parameters", "term", "motion"),
    [
        (7, 6, STRUCTURAL_COMPLIANCE, {}),
        (6, 3, STRUCTURAL_COMPLIANCE, {}),
        (6, 6, LEVER_ARM, {}),
        (6, 6, STRUCTURAL_COMPLIANCE, {"axes": object()}),
        (6, 6, STRUCTURAL_COMPLIANCE, {"tracking": object()}),
    ],
    ids=["a rest more", "fewer parameters", "no turn of the body", "encoders", "poses"],
)
def test_what_more_is_known_of_keeps_its_name(
    rests: int, parameters: int, term: Term, motion: dict[str, Any]
) -> None:
    assert _made_by_placing(placed(rests, term, parameters, **motion)) is None
