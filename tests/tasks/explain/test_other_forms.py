"""Physics of the catalogue, written with other equations than its terms, still gets its name."""

import numpy as np
import other_forms
import pytest
from short_run import short_run

from tasks.explain.explain import explain

pytestmark = pytest.mark.rehearsal


SHORT = 5.0  # s
# What a knock changes is told from the supply's course where it is seen for longer.
DWELLS = {"knock": 10.0, "fading": SHORT}
IN_A_REHEARSAL = (
    ("hysteresis", "preisach_of_rate", 30.0), ("hysteresis", "play_of_force", 30.0),
    ("bias_step", "knock", 10.0), ("bias_step", "gradual_step", 100.0),
    ("vibration_rectification", "rectified", 30.0),
    ("gyro_scale_nonlinearity", "dead_band", 30.0),
    ("accel_nonlinearity", "wave_of_a_converter", 30.0), ("structural_compliance", "sag", 30.0),
)  # fmt: skip


@pytest.mark.parametrize(
    ("effect", "form", "z"),
    [
        ("hysteresis", "fading", 10.0),
        *(pytest.param(*one, marks=pytest.mark.rehearsal) for one in IN_A_REHEARSAL),
    ],
)
def test_a_name_is_a_kind_of_physics_and_not_one_equation(effect: str, form: str, z: float) -> None:
    run = short_run(3, DWELLS.get(form, 6.0))
    signal = getattr(other_forms, form)(run, np.random.default_rng(3007))
    answer = explain(run.with_signal(signal, z))
    assert [finding.effect for finding in answer.findings][:1] == [effect]


def test_a_short_run_without_any_of_them_is_clean() -> None:
    answer = explain(short_run(3, SHORT).recording)
    assert (answer.verdict, answer.findings) == ("no_mismatch", ())
    assert answer.p_value > 0.01
    left = answer.recording.imu.stack(("gyro_x", "accel_x")) - answer.found[:, [0, 3]]
    noise = np.nanstd(left, axis=0) / answer.noise[[0, 3]]
    assert (np.abs(noise - 1.0) < 0.3).all()
