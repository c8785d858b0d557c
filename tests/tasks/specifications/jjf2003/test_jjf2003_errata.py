"""Where JJF 2003-2022 cannot be followed to the letter.

That p, couplings and g-sensitivities are those of models (1) and (2), test_jjf2003_clauses.py
shows by moving each error alone. What is only a slip of the pen stands in the register, and the
certificate prints it.
"""

from typing import get_args

import numpy as np
import pytest

from schemas.calibration import Calibration, UncertaintyKind
from schemas.recording import Recording
from tasks.certificate.fields import slug
from tasks.certificate.statements import evaluation, readings, uncertainty
from tasks.conformity import decide
from tasks.motion.table import EARTH_RATE
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.readings import READINGS
from tasks.uncertainty.monte_carlo import acquisition, combine_as_example
from tasks.words import say
from tests.manifests import at_station
from tests.tasks.items_only import items_only

AXES = "xyz"
DEG = float(np.degrees(1.0))
GRAVITY = 9.78
LATITUDE = 39.9
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")


def result(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def means(recording: Recording, *names: str) -> np.ndarray:
    """Mean readings (n, 6) of the named segments."""
    found = {s.name: recording.imu.rows(s.t_start, s.t_end) for s in recording.manifest.segments}
    columns = np.array(list(recording.imu.columns.values()))
    return np.array([columns[:, found[name]].mean(axis=1) for name in names])


def printed_readings(calibration: Calibration) -> str:
    """The readings of the specification as the certificate prints them, English."""
    return " ".join(
        say(text, "en") for each in readings(calibration) for text in (each.clause, each.text)
    )


def test_eq_7_keeps_the_vertical_part_of_earths_rotation_and_it_is_removed(ideal_run):
    true = np.array([[0.004, 0.001, 0.0], [0.0, -0.006, 0.002], [0.003, 0.0, 0.005]])  # (°/s)/g
    vertical = DEG * EARTH_RATE * np.sin(np.radians(LATITUDE))
    felt = true + vertical * np.eye(3)  # an axis up reads +ω_e·sin φ, an axis down −ω_e·sin φ
    recording = at_station(ideal_run(G=np.radians(felt) / GRAVITY), latitude_deg=LATITUDE)
    g = result(recording).items["gyro_g_sensitivity"]
    for i, j in np.ndindex(3, 3):
        element = AXES[i] + AXES[j]
        assert g.value_without_earth_rotation[element] == pytest.approx(true[i, j], abs=1e-8)
    positions = means(
        recording, *(f"position_{up}_{turn}" for up in UPS for turn in ("000", "180"))
    )
    U = positions[:, :3].reshape(6, 2, 3).mean(axis=1).T
    A = np.zeros((4, 6))
    for column, up in enumerate(UPS):
        A[AXES.index(up[1]), column], A[3, column] = (1.0 if up[0] == "+" else -1.0), 1.0
    as_printed = DEG * (U @ A.T @ np.linalg.inv(A @ A.T))
    assert g.value["xx"] == pytest.approx(as_printed[0, 0], abs=1e-8)
    assert np.diag(as_printed)[:3] - np.diag(true) == pytest.approx(3 * [0.00268], abs=1e-5)


@pytest.mark.parametrize(
    ("reading", "statement"),
    [
        ("jjf2003.p_turning", "“at rest”"),
        ("jjf2003.p_sign", "the negative of p in model (2)"),
        ("jjf2003.p_lever_arm", "holds for the mounting position"),
        ("jjf2003.p_unit", "in metres"),
        ("jjf2003.g_earth", "too large by ω_e·sin φ per g"),
        ("jjf2003.k_azx", "K_axz appears twice"),
        ("jjf2003.input_matrix", "is the same 4 × 6 matrix"),
        ("jjf2003.k_gzy", "lacks K_gzy"),
        ("jjf2003.positions", "two headings 180° apart"),
    ],
)
def test_the_register_has_the_reading_and_the_certificate_prints_it(ideal_run, reading, statement):
    assert statement in say(READINGS[reading].text, "en")
    assert say(READINGS[reading].text, "zh")
    assert statement in printed_readings(result(ideal_run()))


def test_the_number_of_effective_bits_is_the_units_own():
    assert acquisition(12) == pytest.approx(1.41e-4, abs=5e-7)
    assert acquisition(16) == pytest.approx(acquisition(12) / 16)
    assert combine_as_example("K", "1", 1.0, [0.0], bits=16).inputs[1].u == acquisition(16)


@pytest.mark.parametrize("kind", get_args(UncertaintyKind))
def test_the_certificate_says_which_evaluation_was_used(ideal_run, kind):
    calibration = result(ideal_run())
    items = {
        name: each.model_copy(update={"uncertainty_kind": kind})
        for name, each in calibration.items.items()
    }
    made = calibration.model_copy(update={"items": items})
    statements = (*uncertainty(made), *evaluation(made, decide(made, None), JJF2003))
    ids = [each.id for each in statements if each.id.startswith("certificate-u-contains")]
    assert ids == [f"certificate-u-contains.{slug(kind)}"]


def test_the_register_has_the_symbol_of_a_3_2_3():
    assert "U_gx1" in say(READINGS["jjf2003.u_gx1"].text, "en")
    assert "N_gx1" in say(READINGS["jjf2003.u_gx1"].text, "zh")
