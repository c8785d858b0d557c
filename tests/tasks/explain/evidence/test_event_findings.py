"""How clear an event must be to be a finding."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from explained import explanation, finding, nothing_added

from tasks.explain.events.code_fault import CodeFault
from tasks.explain.events.faults import RangeSetting
from tasks.explain.evidence.event_findings import OF_A_LIMIT, _needed, with_faults
from tasks.explain.explanation import Explanation
from tasks.words import message


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
