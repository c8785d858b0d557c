"""Beside an implausible finding, what the others would be without it."""

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, read, selected

from tasks.explain.evidence.dependence import change_without
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.findings import _beside_implausible, scrutinised
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
ARM = np.array([0.04, -0.06, 0.03])
LONG = 3.0 * LEVER_ARM.parameters[0].plausible[1] * np.ones(3)


def readings(delay: float, arm: np.ndarray) -> np.ndarray:
    """(n, 6) of a unit with a delay in s and a lever arm in m."""
    return read(RUN, (TIME_OFFSET, [delay]), (LEVER_ARM, arm)) + noise(len(RUN.t), 54, NOISY)


def test_u_as_stated_covers_what_a_parameter_would_be_without_what_is_implausible() -> None:
    """A delay of 20 ms beside a lever arm three times too long."""
    made = readings(0.02, LONG)
    both, alone = (
        Evidence.of(selected(made, TIME_OFFSET, LEVER_ARM)),
        selected(made, TIME_OFFSET).model,
    )
    change = np.abs(alone.values[alone.places[TIME_OFFSET.key]] - both.own[0][1])
    found = scrutinised(both)
    stated = _beside_implausible(both, found)
    assert found[0].u < 0.1 * change
    assert stated[0].u == pytest.approx(change, rel=0.1)
    assert stated[1].u == pytest.approx(found[1].u)


def test_what_is_named_and_what_is_determined_stays() -> None:
    """A delay a tenth beyond what is plausible, beside a lever arm known to 20 µm."""
    made = readings(1.1 * TIME_OFFSET.parameters[0].plausible[1], ARM)
    both = Evidence.of(selected(made, TIME_OFFSET, LEVER_ARM))
    found = scrutinised(both)
    assert [one.refusal and one.refusal.kind for one in found.values()] == ["implausible", None]
    assert (found[1].u < 1e-4).all()
    assert (change_without(both, [0])[both.own[1][0]] > 1e-3).any()
