"""Clipping that no plateau shows, beside scale factors that bend."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.evidence.bent_end import bends_at_one_end
from tasks.motion.whole import Motion

RUN = motion()
TOP = 2.0  # rad/s
SWINGING = replace(RUN, rate=np.outer(TOP * np.sin(0.7 * RUN.t), [0.0, 0.2, 1.0]))


def added(motion: Motion, channel: int, change: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    contribution = np.zeros((len(motion.t), 6))
    contribution[:, channel] = change(motion.rate[:, channel])
    return contribution


@pytest.mark.parametrize(
    ("change", "clipped"),
    [
        (lambda rate: -np.maximum(rate - 0.9 * TOP, 0.0), True),
        (lambda rate: np.maximum(-rate - 0.9 * TOP, 0.0) + 1e-3 * rate, True),
        (lambda rate: 1e-3 * rate**2, False),
        (lambda rate: 1e-3 * rate**3, False),
        (lambda rate: 1e-3 * np.abs(rate), False),
        (lambda rate: 1e-3 * np.sin(3.0 * rate), False),
    ],
)
def test_a_bend_at_one_end_alone_may_be_clipping(
    change: Callable[[np.ndarray], np.ndarray], clipped: bool
) -> None:
    names = bends_at_one_end("gyro_scale_nonlinearity", added(SWINGING, 2, change), SWINGING)
    assert names == (("gyro_saturation",) if clipped else ())


def test_what_bends_no_scale_factor_is_no_clipping() -> None:
    clipped = added(SWINGING, 2, lambda rate: -np.maximum(rate - 0.9 * TOP, 0.0))
    assert bends_at_one_end("temperature_scale", clipped, SWINGING) == ()
    nothing = np.zeros_like(clipped)
    assert bends_at_one_end("gyro_scale_nonlinearity", nothing, SWINGING) == ()
