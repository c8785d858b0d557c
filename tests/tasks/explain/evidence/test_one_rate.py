"""What a run of one size of rate leaves open."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.evidence.one_rate import possibly_clipped
from tasks.motion.whole import Motion

NONLINEAR = "gyro_scale_nonlinearity"
RUN = motion()


def held_at(*rates: float) -> Motion:
    """Rates (rad/s) about z, each held for half a minute, with ramps of two seconds between."""
    corners = np.cumsum([0.0, *(each for _ in rates for each in (2.0, 30.0, 2.0, 5.0))])
    sizes = np.concatenate([[0.0], *([rate, rate, 0.0, 0.0] for rate in rates)])
    rate = np.zeros((len(RUN.t), 3))
    rate[:, 2] = np.interp(RUN.t, corners, sizes)
    return replace(RUN, rate=rate, acceleration=np.gradient(rate, RUN.t, axis=0))


@pytest.mark.parametrize(
    ("rates", "open_"),
    [((2.0, -2.0), True), ((2.0, -2.0, 0.3), True), ((2.0, -2.0, 1.2), False), ((2.0, 1.0), False)],
)
def test_clipping_is_possible_where_one_size_of_rate_was_held(
    rates: tuple[float, ...], open_: bool
) -> None:
    names = possibly_clipped(NONLINEAR, (2, 5), held_at(*rates))
    assert names == (("gyro_saturation",) if open_ else ())


def test_a_rate_that_never_stays_shows_the_whole_curve() -> None:
    rate = np.zeros((len(RUN.t), 3))
    rate[:, 2] = 2.0 * np.sin(RUN.t)
    swinging = replace(RUN, rate=rate, acceleration=np.gradient(rate, RUN.t, axis=0))
    assert possibly_clipped(NONLINEAR, (2,), swinging) == ()


def test_only_a_bent_scale_factor_may_be_clipping() -> None:
    assert possibly_clipped("gyro_g2_sensitivity", (2,), held_at(2.0, -2.0)) == ()
    assert possibly_clipped(NONLINEAR, (3, 4), held_at(2.0, -2.0)) == ()
