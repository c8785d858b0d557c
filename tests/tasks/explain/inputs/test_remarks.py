"""What the station found of the unit's clock is told where it can matter, and only there."""

from typing import Any

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.explain.inputs.remarks import clock_remarks
from tasks.words import say
from tests.manifests import manifest_of

CLOCK = {
    "at_s": 300.0, "offset_s": -0.004, "half_width_s": 0.01, "u_offset_s": 0.006, "skew": 1e-6,
    "u_skew": 1e-7,
}  # fmt: skip


def recording(**extra: Any) -> Recording:
    manifest = manifest_of("clocked", **extra)
    return Recording(manifest, Stream(np.arange(3.0), {}))


def statement(**extra: Any) -> list[str]:
    return [say(remark, "en") for remark in clock_remarks(recording(**extra))]


def test_the_clocks_part_of_a_delay_is_told_with_its_uncertainty() -> None:
    (document,) = statement(unit_clock=CLOCK)
    assert "4.0 ms ± 12.0 ms" in document


def test_stamps_that_were_moved_to_the_tables_clock_leave_the_rest() -> None:
    (document,) = statement(unit_clock=CLOCK | {"offset_s": 7.001}, unit_clock_shift_s=7.0)
    assert "-1.0 ms ± 12.0 ms" in document


@pytest.mark.parametrize(
    "extra",
    [
        {},
        {"unit_clock": CLOCK | {"u_offset_s": 0.2}},
        {"unit_clock": {n: value for n, value in CLOCK.items() if n != "half_width_s"}},
        {"unit_clock": CLOCK, "unit_power_on_s": [30.0]},
        {"unit_clock": "slow"},
        {"unit_clock": CLOCK, "unit_clock_shift_s": "much"},
    ],
    ids=["not compared", "too uncertain", "of an earlier version", "switched on again", "text",
         "no number"],
)  # fmt: skip
def test_what_is_not_known_well_enough_is_not_told(extra: dict[str, Any]) -> None:
    assert statement(**extra) == []
