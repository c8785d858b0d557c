"""The rates that a unit reads against those of the encoders, over time."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from schemas.recording import GYRO, Recording, Stream
from tasks.run_validity.clocks import clock_remarks
from tasks.specifications.evidence import ClauseEvidence
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import station_file

T = np.arange(0.0, 120.0, 0.01)
BIAS = np.radians([1.0, -2.0, 3.0])
RATE = np.radians(90.0)
RAMP_S = 0.75


def turned(t: np.ndarray, from_s: float) -> np.ndarray:
    """Angle (rad) of an axis that turns for 6 s from 20 s on, and from `from_s` to the end."""
    knots = np.array([20.0, 20.0 + RAMP_S, 26.0, 26.0 + RAMP_S, from_s, from_s + RAMP_S, 1e3])
    rates = RATE * np.interp(T, knots, [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])
    return np.interp(t, T, np.concatenate([[0.0], np.cumsum(rates[:-1] * 0.01)]))


@pytest.fixture
def recorded(ideal_run: Any) -> Any:
    """A recording of that motion, whose unit is so many seconds late."""

    def make(from_s: float, late_s: float) -> ClauseEvidence:
        still = np.zeros(len(T))
        z = np.gradient(turned(T - late_s, from_s), 0.01)
        readings = np.array([still, still, z]).T + BIAS
        imu = Stream(T, dict(zip(GYRO, readings.T, strict=True)))
        angles = {"outer_angle": turned(T, from_s), "middle_angle": still, "inner_angle": still}
        manifest = ideal_run(dwell=1.0).manifest
        measured_by = station_file(VirtualStation(), 1.0, "host", 1, 2).station
        manifest = manifest.model_copy(update={"station": measured_by})
        recording = Recording(manifest, imu, Stream(T, angles), None, None)
        return cast(ClauseEvidence, SimpleNamespace(recording=recording))

    return make


@pytest.mark.parametrize("from_s", [35.0, 50.0, 95.0])
def test_clocks_agree_however_long_the_table_turns(from_s, recorded):
    assert list(clock_remarks(recorded(from_s, 0.0))) == []


@pytest.mark.parametrize("from_s", [35.0, 95.0])
@pytest.mark.parametrize("late_s", [-1.4, 0.3, 1.0])
def test_clocks_that_are_apart_make_the_run_invalid(late_s, from_s, recorded):
    (remark,) = clock_remarks(recorded(from_s, late_s))
    assert (remark.code, remark.run) == ("clocks_apart", "invalid")
    assert f"{late_s:+.2f} s" in remark.en
