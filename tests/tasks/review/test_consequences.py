"""What an effect moves in a certificate is what a recording without it would have given."""

import numpy as np
import pytest

from schemas.discrepancy import Consequence
from tasks.calibrate.calibrate import calibrate
from tasks.review.consequences import moved_elements, touched_of, with_touched
from tasks.review.hypotheses import Effect
from tasks.review.report import review_of
from tasks.review.run_statistics import statistics_of
from tasks.review.search import search
from tasks.specifications.register import specification_for
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate
from tests.tasks.review.fleet import fleet, of

QUADRATIC = (2e-3, -1e-3, 1.5e-3)  # of an accelerometer's reading in g


def case(*effects: EffectCall) -> Case:
    return Case(seed=1, procedure="rests", rate_hz=20, dwell_s=5.0, effects=effects)


def test_the_elements_move_by_what_the_effect_did_to_them() -> None:
    parameters = {"coefficient": list(QUADRATIC), "order": 2}
    call = EffectCall(name="accel_nonlinearity", parameters=parameters)
    bent, plain = simulate(case(call)).recording, simulate(case()).recording
    named = [each for each in statistics_of(bent).layout.terms if each.name == call.name]
    term = next(each for each in named if each.at == (2.0,))
    elements = moved_elements(bent, Effect(term, (0, 1, 2)), np.array(QUADRATIC))
    truth = calibrate(specification_for(plain.manifest.standard), plain, run="", code_version="")
    assert {"x", "y", "z"} <= {each.element for each in elements if each.item == "accel_bias"}
    for each in elements:
        assert each.U is not None
        without = truth.items[each.item].value[each.element]
        assert each.after == pytest.approx(without, abs=0.2 * each.U)


def test_a_finding_tells_what_it_moves_the_most_first() -> None:
    pool = fleet(1, lambda unit, station, day: of("axis_tilt", 2.0 * (station == 2)))
    (finding,) = review_of(pool, *search(pool)).findings
    moved = [
        Consequence(item="gyro_bias", element=e, before=0.0, after=a, U=0.1, unit="deg/s")
        for e, a in (("x", 0.02), ("y", -0.3))
    ]
    complete = with_touched(finding, list(touched_of("C-1", moved)), 3)
    assert [(each.element, round(each.in_U, 3)) for each in complete.touched] == [
        ("y", -3.0), ("x", 0.2)
    ]  # fmt: skip
    assert "1 of 3; largest change: C-1" in complete.statement.en
    assert "C-1" in complete.statement.zh
    assert "0.05 U" in with_touched(finding, [], 3).statement.en
    assert with_touched(finding, [], 0) == finding
