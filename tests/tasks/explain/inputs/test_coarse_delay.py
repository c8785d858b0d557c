"""A long delay is told by the slow motion first: a fast one knows it only to within a period."""

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.explain.channels import CHANNELS
from tasks.explain.inputs.coarse_delay import MIN_DELAY, coarse_delay
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.inputs.prepared import advanced
from tasks.motion.whole import Motion
from tests.manifests import manifest_of

T = np.arange(0.0, 60.0, 0.01)
NOISE = 0.01  # rad/s


def rate(t: np.ndarray) -> np.ndarray:
    """Strokes of 8 s and a resonance of 13 Hz that is nearly as fast."""
    return np.asarray(np.sin(2.0 * np.pi * t / 8.0) + 0.5 * np.sin(2.0 * np.pi * 13.0 * t))


def shaft(late: float, moved: float = 1.0) -> FullRate:
    """A unit about whose y axis a shaft turns; its gyros have scale, cross coupling and bias."""
    nothing = np.zeros(len(T))
    speed = np.column_stack([nothing, moved * rate(T), nothing])
    level = np.tile([0.0, 0.0, 1.0], (len(T), 1))
    motion = Motion(T, level, np.full((len(T), 3), np.nan), speed, np.zeros_like(speed), 9.8)
    readings = np.zeros((len(T), 6))
    readings[:, :3] = moved * rate(T - late)[:, None] * [0.02, 0.97, -0.01] + 0.05
    readings[:, :3] += NOISE * np.random.default_rng(8).standard_normal((len(T), 3))
    one = np.ones((1, 2))
    return FullRate(readings, motion, np.full(len(T), -1), (), one, np.zeros(6), np.ones(6, bool))


@pytest.mark.parametrize("late", [0.012, 0.034, 0.1, -0.034, -0.2])
def test_a_delay_of_more_than_half_a_period_is_told(late: float) -> None:
    assert coarse_delay(shaft(late)) == pytest.approx(late, abs=0.002)


@pytest.mark.parametrize("late", [0.0, 0.6 * MIN_DELAY])
def test_a_short_delay_is_left_to_the_fit(late: float) -> None:
    assert coarse_delay(shaft(late)) == 0.0


def test_rests_and_a_short_run_tell_no_delay() -> None:
    assert coarse_delay(shaft(0.05, moved=0.0)) == 0.0
    whole = shaft(0.05)
    few = FullRate(
        whole.readings[:150], whole.motion.taken(np.arange(150)), whole.segment[:150], (),
        whole.segment_variance, whole.steps, whole.dithered,
    )  # fmt: skip
    assert coarse_delay(few) == 0.0


def test_what_is_not_known_is_not_compared() -> None:
    """The motion of a third of the run is not told, and the gyros read nonsense there."""
    whole = shaft(0.05)
    whole.motion.rate[2000:4000] = np.nan
    whole.readings[2000:4000] = 30.0
    assert coarse_delay(whole) == pytest.approx(0.05, abs=0.002)


def test_only_what_is_before_a_loss_is_looked_at() -> None:
    whole = shaft(0.05)
    whole.readings[3000:, :3] = shaft(-0.1).readings[3000:, :3]
    assert coarse_delay(whole, until=30.0) == pytest.approx(0.05, abs=0.002)


def test_stamps_are_taken_back() -> None:
    manifest = manifest_of("late", {"gravity_m_s2": 9.8})
    read = Recording(manifest, Stream(T, {name: np.zeros(len(T)) for name in CHANNELS}))
    assert advanced(read, 0.03).imu.t == pytest.approx(T - 0.03)
