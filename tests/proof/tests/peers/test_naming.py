"""A regressor gets a name where it has one fair reading, and none elsewhere."""

import pytest

from tests.proof.peers.naming import dimension_of, reading_of
from tests.proof.peers.peer import UNNAMED, in_order


@pytest.mark.parametrize(
    ("channel", "regressor", "name"),
    [
        (0, "ω_x²", "gyro_scale_nonlinearity"),
        (1, "ω_x²", None),
        (2, "|ω_z|", "gyro_scale_asymmetry"),
        (0, "u_x·u_y", "gyro_g2_sensitivity"),
        (1, "ω_y·u_x", "gyro_scale_g_dependence"),
        (1, "ω_x·u_y", None),
        (0, "ω_x·T", "temperature_scale"),
        (3, "ω_x·ω_y", "lever_arm"),
        (4, "ω_x·ω_y", "lever_arm"),
        (5, "ω_x·ω_y", None),
        (4, "u_y³", "accel_nonlinearity"),
        (5, "exp(-t/300)", "thermal_transient"),
        (0, "α_x", None),
        (0, "H", None),
        (0, "t", None),
    ],
)
def test_reading(channel: int, regressor: str, name: str | None) -> None:
    assert reading_of(channel, regressor) == name


def test_dimension_is_what_the_regressor_follows() -> None:
    regressors = ("ω_x·u_y", "u_x²", "ω_x·T", "|ω_x|", "t", "exp(-t/60)", "vibration", "V")
    assert [dimension_of(one) for one in regressors] == [
        "rate", "attitude", "temperature", "rate", "time", "time", "recorded", "recorded",
    ]  # fmt: skip


def test_names_come_by_strength_and_slight_ones_stay_unnamed() -> None:
    names = [(10.0, "a"), (300.0, "b"), (90.0, "a"), (2.0, "c")]
    assert in_order(names) == ("b", "a", UNNAMED)
