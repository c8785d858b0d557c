"""A law of the attitude has no name where errors of placing the unit would look the same."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.placements import made_by_placing
from tasks.model.term import Term
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE

ROWS = 20  # of each segment, and between them


def evidence_of(rests: int, term: Term, parameters: int = 6, **motion: Any) -> Evidence:
    """A run of rests with a turn after each, told by labels unless `motion` says otherwise."""
    segment = np.tile(np.repeat([0, -1], ROWS), rests)
    segment[segment == 0] = np.repeat(np.arange(rests), ROWS)
    rate = np.where(segment[:, None] >= 0, 0.0, 0.3) * np.ones(3)
    fields = {"axes": None, "tracking": None, "rate": rate} | motion
    blocks = SimpleNamespace(motion=SimpleNamespace(**fields), segment=segment)
    return cast(Evidence, SimpleNamespace(
        fit=SimpleNamespace(blocks=blocks), own=[(list(range(parameters)), None)],
        groups=[SimpleNamespace(terms=(term,), name=term.name)],
    ))  # fmt: skip


def test_six_labelled_rests_tell_no_fixture_that_bends() -> None:
    refusal = made_by_placing(evidence_of(6, STRUCTURAL_COMPLIANCE), 0)
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
    assert made_by_placing(evidence_of(rests, term, parameters, **motion), 0) is None
