"""The judge of runs that were killed and went on: what it compares, and how it says so."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003
from tests.proof.faults.run_with_fault import short_procedure
from tests.proof.kills.resume import Resumed, as_markdown, run_all, summary, worst_difference


@pytest.fixture
def whole(ideal_run: Callable[..., Recording]) -> Calibration:
    return calibrate(JJF2003, ideal_run(dwell=1.0), run="r", code_version="v")


def changed(calibration: Calibration, **values: float | None) -> Calibration:
    """With another value of a gyro's scale factor."""
    item = calibration.items["gyro_scale_factor"]
    other = item.model_copy(update={"value": item.value | values})
    return calibration.model_copy(
        update={"items": calibration.items | {"gyro_scale_factor": other}}
    )


def test_the_largest_difference_is_counted_in_u_and_has_its_element(whole: Calibration) -> None:
    U = whole.items["gyro_scale_factor"].U["y"]
    assert U is not None
    other = changed(whole, y=1.0 + 0.5 * U, z=1.0 + 0.2 * U)
    worst, element = worst_difference(other, whole)
    assert worst == pytest.approx(0.5 / np.sqrt(2.0), rel=1e-3)
    assert element == "gyro_scale_factor.y"


def test_a_value_that_one_run_lacks_differs_without_bound(whole: Calibration) -> None:
    assert worst_difference(changed(whole, x=None), whole) == (
        float("inf"), "gyro_scale_factor.x",
    )  # fmt: skip


def test_the_page_says_how_many_hold_and_has_a_row_for_each() -> None:
    found = [
        Resumed(1, 3.25, 4, 14, "valid", 0.31, "gyro_bias.x"),
        Resumed(2, 0.5, 0, 18, "valid", 1.2, "accel_bias.z"),
    ]
    assert [each.holds for each in found] == [True, False]
    assert "2 acquisitions" in summary(found)
    assert ": 1 have the values" in summary(found)
    assert "| 2 | 0.5 | 0 | 18 | valid | 1.20 | accel_bias.z |" in as_markdown(found)


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_a_run_that_was_killed_and_went_on_has_the_values_of_a_whole_one(tmp_path: Path) -> None:
    (one,) = run_all(tmp_path, 1, short_procedure(3.0, "x"), lambda done, count: None)
    assert one.worst < 2.0  # four standard uncertainties: brief segments are mostly noise
    assert one.kept + one.again == 10
