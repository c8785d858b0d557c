"""What a finding earns, and which findings are no more than chance."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read

from schemas.discrepancy import HeldOut
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.groups import FindingGroup, finding_groups
from tasks.explain.evidence.pruning import unsupported
from tasks.explain.explanation import UNNAMED
from tasks.explain.search.candidates import Candidate, Prior
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS, THERMAL_GRADIENT
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.memory import bias_step
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.table import rate_ripple

RUN = motion()
EARTH = earth_rotation(np.radians(40.0))
ARM = (0.004, -0.006, 0.003)
TRIED = 300  # candidates


def picked(
    term: Term,
    own: tuple[int, ...] | None = None,
    prior: Prior | None = None,
    absorbed_by: str | None = None,
) -> Selected:
    own = tuple(range(len(term.parameters))) if own is None else own
    return Selected(Candidate(term, own or (0,), own, 1, prior), 100.0, 90.0, (), absorbed_by)


def found(*chosen: Selected) -> Selection:
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    return Selection(chosen, NOISY, 0.0, nothing)


def weighed(made: np.ndarray, chosen: Sequence[Selected]) -> tuple[Evidence, list[FindingGroup]]:
    free = [replace(one, candidate=replace(one.candidate, prior=None)) for one in chosen]
    fit = FittedSelection.of(found(*free), observed(made, RUN), RATE)
    evidence = Evidence.of(replace(fit, selection=found(*chosen)))
    return evidence, list(evidence.groups)


@pytest.fixture(scope="module")
def three() -> tuple[Evidence, list[FindingGroup]]:
    """An arm that is there, Earth that is there, a gradient that is not."""
    made = read(RUN, (EARTH, ()), (LEVER_ARM, ARM)) + noise(len(RUN.t), 41, NOISY)
    return weighed(made, [picked(LEVER_ARM), picked(THERMAL_GRADIENT), picked(EARTH)])


def test_the_same_name_is_one_finding() -> None:
    parts = [picked(TEMPERATURE_BIAS, (0,)), picked(LEVER_ARM), picked(TEMPERATURE_BIAS, (4,))]
    groups = finding_groups(found(*parts))
    assert [group.name for group in groups] == ["temperature_bias", "lever_arm"]
    assert groups[0].terms == (TEMPERATURE_BIAS,)
    assert groups[0].selected == (parts[0], parts[2])


def test_two_steps_are_jumps_without_a_name_and_one_is_a_step() -> None:
    first, later = bias_step(0, 100.0), replace(bias_step(0, 250.0), variant=1)
    (jumps,) = finding_groups(found(picked(first, (0,)), picked(later, (0,))))
    assert (jumps.name, len(jumps.terms)) == (UNNAMED, 2)
    (once,) = finding_groups(found(picked(first, (0,)), picked(first, (1,))))
    assert once.name == "bias_step"
    (both,) = finding_groups(found(picked(first), picked(bias_step(3, 100.0))))
    assert both.name == "bias_step"  # gyros and accelerometers at the same moment
    soon = picked(bias_step(3, 102.0))
    assert finding_groups(found(picked(first), soon))[0].name == "bias_step"


@pytest.mark.parametrize(
    ("orders", "name"), [((6, 7, 8), UNNAMED), ((7, 14), "rate_ripple"), ((7,), "rate_ripple")]
)
def test_neighbouring_orders_of_a_ripple_are_something_at_one_place_of_the_turn(
    orders: tuple[int, ...], name: str
) -> None:
    (one,) = finding_groups(found(*(picked(rate_ripple(order, 1)) for order in orders)))
    assert one.name == name


def test_the_gain_is_the_chi_squared_of_what_was_found(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    """Of physics without a parameter: of a fit without it, less one with it at its own size."""
    one, groups = three
    made = read(RUN, (EARTH, ()), (LEVER_ARM, ARM)) + noise(len(RUN.t), 41, NOISY)
    other, _ = weighed(made, [picked(LEVER_ARM), picked(THERMAL_GRADIENT)])
    rows = slice(0, other.whole.count)
    chi2 = []
    for each in (other, one):  # what is known comes behind what is fitted
        normal, right, misfit = each.whole.normal()
        block = normal[rows, rows] + np.diag(each.prior[rows])
        chi2.append(misfit - right[rows] @ np.linalg.pinv(block, rcond=1e-12) @ right[rows])
    assert one.gain([group.name for group in groups].index("earth_rotation")) == pytest.approx(
        chi2[0] - chi2[1], rel=0.02
    )


def test_what_is_there_is_needed_and_what_is_not_is_needless(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    one, groups = three
    weak = {group.name: unsupported(one, n, TRIED) for n, group in enumerate(groups)}
    assert weak == {"lever_arm": False, "thermal_gradient": True, "earth_rotation": False}


def test_what_is_there_earns_on_segments_that_were_not_seen(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    one, groups = three
    earned = {group.name: one.held_out_gain(n) for n, group in enumerate(groups)}
    assert earned["lever_arm"] > 50.0
    assert earned["earth_rotation"] > 10.0
    assert earned["thermal_gradient"] < 5.0


def test_unseen_segments_are_noise_after_and_worse_before(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    text: HeldOut = three[0].held_out(np.zeros(6))
    assert text.chi2_per_dof_after == pytest.approx(1.0, abs=0.05)
    assert text.chi2_per_dof_before > text.chi2_per_dof_after
    assert set(text.rms_ratio) == set(CHANNELS)
    assert max(text.rms_ratio.values()) < 1.01
    assert min(text.rms_ratio.values()) < 0.98


def test_what_events_remove_is_missing_from_unseen_segments_before(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    evidence, removed = three[0], np.array([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])
    plain, beside = evidence.held_out(np.zeros(6)), evidence.held_out(removed)
    assert beside.chi2_per_dof_after == plain.chi2_per_dof_after
    more = beside.chi2_per_dof_before - plain.chi2_per_dof_before
    assert more == pytest.approx(3.0 / 6, rel=0.01)  # one of six channels
    powers = [one.rms_ratio["accel_x"] ** -2 for one in (plain, beside)]  # before, over noise
    assert powers[1] - powers[0] == pytest.approx(3.0, rel=0.05)
    assert beside.rms_ratio["gyro_x"] == plain.rms_ratio["gyro_x"]


def test_random_drifts_and_what_is_absorbed_are_not_judged_by_a_gain() -> None:
    """The first are charged by their evidence; of the others no residual is left."""
    made = read(RUN) + noise(len(RUN.t), 42, NOISY)
    series = picked(THERMAL_GRADIENT, prior=Prior(2.0, 1.0))
    absorbed = picked(LEVER_ARM, absorbed_by="gyro_g_sensitivity")
    one, groups = weighed(made, [series, absorbed])
    assert [unsupported(one, n, TRIED) for n in range(len(groups))] == [False, False]
