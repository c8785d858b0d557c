"""What several recordings of one unit show together, of a plant that shares no code with it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from schemas.discrepancy import (
    Detection,
    Discrepancy,
    EvidenceFor,
    HeldOut,
    ReportedFinding,
    RunStatistics,
)
from schemas.text import Statement
from tasks.review.pool import Pool, ReviewedRun, pooled, statistics_of
from tasks.review.several_recordings import (
    FoundTogether,
    discrepancy_together,
    found_together,
    held_out_gain,
)
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate
from tests.tasks.review.fleet import NOTHING, fleet, of, place

WEAK = EffectCall(  # z = 4 in one recording
    name="gyro_g2_sensitivity",
    parameters={"M": [
        [-1.92e-7, 0.746e-7, 1.29e-7], [-0.749e-7, -4.68e-7, 1.18e-7], [2.61e-7, 1.02e-7, -1.8e-7],
    ]},
)  # fmt: skip


@cache
def statistics(seed: int, *effects: str) -> RunStatistics:
    """Of a recording of one unit, with the weak effect where it is named."""
    case = Case(
        seed=seed, unit_seed=5, grade="industrial", procedure="three_axis", rate_hz=20,
        rates_deg_s=(30.0, 120.0), dwell_s=5.0, effects=(WEAK,) if effects else (),
    )  # fmt: skip
    return statistics_of(simulate(case).recording)


def together(*some: RunStatistics) -> Pool:
    carriers = {"unit": "SN1", "station": "S1"}
    return pooled([(ReviewedRun(f"r{k}", f"{k}", carriers), one) for k, one in enumerate(some)])  # type: ignore[arg-type]


def test_an_effect_too_weak_for_one_recording_is_named_from_four():
    four = [statistics(seed, WEAK.name) for seed in range(21, 25)]
    (one,), p_value = found_together(together(*four))
    assert (one.effect.name, one.names) == (WEAK.name, ())
    assert p_value < 0.01
    assert one.held_out > 0.0
    assert one.homogeneity_p is not None
    assert one.homogeneity_p > 0.01
    for alone in four:
        assert found_together(together(alone))[0] == ()


@pytest.mark.rehearsal
def test_two_clean_recordings_name_nothing():
    assert found_together(together(statistics(21), statistics(22)))[0] == ()


def test_a_unit_has_one_value_and_each_mounting_its_own():
    sizes = (6.0, -6.0, 6.0)
    unit = fleet(1, lambda unit, station, day: of("size_effect", 4.0), runs=3, units=1, stations=1)
    mounted = fleet(
        2, lambda unit, station, day: of("lever_arm", sizes[day]), runs=3, units=1, stations=1
    )
    (common,), _ = found_together(unit)
    (own,), _ = found_together(mounted)
    assert (common.effect.name, len(common.values)) == ("size_effect", 1)
    assert common.values[0] == pytest.approx(np.full(3, 4.0), abs=3.0)
    assert (own.effect.name, own.homogeneity_p) == ("lever_arm", None)
    assert np.sign(own.values.mean(axis=1)).tolist() == [1.0, -1.0, 1.0]


def test_a_value_that_does_not_hold_in_the_other_recording_is_no_name():
    opposite = fleet(
        1, lambda unit, station, day: of("size_effect", (12.0, -6.0)[day]), runs=2, units=1,
        stations=1,
    )  # fmt: skip
    found, p_value = found_together(opposite)
    assert "size_effect" not in [one.effect.name for one in found]
    assert p_value < 1e-6
    words = discrepancy_together("Maker M 1", (), p_value, [answer("a")] * 2, [answer("a")] * 2)
    assert words.verdict == "unexplained"
    assert "depart" in words.statement.en


def in_one_recording() -> FoundTogether:
    """An effect of one mounting each, which no other recording can test."""
    pool = fleet(2, lambda unit, station, day: of("lever_arm", 6.0), runs=1, units=1, stations=1)
    (found,), _ = found_together(pool)
    return found


def test_what_no_other_recording_tells_is_tested_on_parts_of_its_own():
    found = in_one_recording()
    assert found.held_out is None
    assert held_out_gain(found, [answer("a")]) == 0.0
    assert held_out_gain(found, [answer("a", 12.5), answer("b", 2.5)]) == 15.0


def test_recordings_that_see_different_axes_do_not_test_each_other():
    pool = fleet(2, lambda unit, station, day: of("size_effect", 9.0), runs=2, units=1, stations=1)
    (group,) = pool.groups
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    score, inverse = group.score.copy(), group.inverse.copy()
    score[:, place("size_effect")] *= axes
    inverse[:, place("size_effect")] *= axes
    apart = replace(pool, groups=(replace(group, score=score, inverse=inverse),))
    (found, *_), _ = found_together(apart)
    assert (found.effect.name, found.held_out) == ("size_effect", None)


def answer(recording: str, gain: float | None = None) -> Discrepancy:
    """What explain says of a recording; gain: held-out, of a lever arm that it found."""
    words = Statement(en="Nothing stands out.", zh="未见异常。")
    return Discrepancy(
        recording_id=recording, digest="d", model=words, verdict="no_mismatch", statement=words,
        detection=Detection(p_value=0.4, false_alarm_rate=0.01), explained_share=0.0,
        left_over={"gyro_x": 1.1}, held_out=HeldOut(
            rms_ratio={"gyro_x": 1.0}, chi2_per_dof_before=1.2, chi2_per_dof_after=1.0
        ),
        findings=() if gain is None else (finding(gain),),
    )  # fmt: skip


def finding(gain: float) -> ReportedFinding:
    words = Statement(en="A lever arm.", zh="杆臂。")
    return ReportedFinding(
        effect="lever_arm", family="geometry", title=words, channels=("accel_x",), where=(),
        parameters=(), evidence=EvidenceFor(delta_bic=30.0, held_out_gain_nats=gain), share=0.5,
        homogeneity_p=None, group=None, equation="", source="", next=words, statement=words,
    )  # fmt: skip


def test_the_answer_is_that_of_one_recording_with_what_each_says_beside_it():
    pool = fleet(
        2, lambda unit, station, day: of("lever_arm", 6.0), runs=3, units=1, stations=1
    )  # fmt: skip
    alone = [answer(name) for name in ("a", "b", "c")]
    wording = discrepancy_together("Maker M 1", *found_together(pool), alone, alone)
    (finding,) = wording.findings
    assert (wording.recording_id, wording.verdict) == ("a + b + c", "explained")
    assert [p.name for p in finding.parameters[::3]] == ["p0 (a)", "p0 (b)", "p0 (c)"]
    assert "3 recordings of Maker M 1" in wording.statement.en
    assert wording.remarks[0].en == "a alone: Nothing stands out."
    clean = fleet(3, lambda unit, station, day: NOTHING, runs=3, units=1, stations=1)
    none = discrepancy_together("Maker M 1", *found_together(clean), alone, alone)
    assert (none.verdict, none.findings) == ("no_mismatch", ())
