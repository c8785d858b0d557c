"""Where JJF 2003-2022 cannot be followed to the letter, entry by entry.

Our value equals the truth on ideal data; the formula as printed, written out here, does not. What
is only a slip of the pen stands in the register, and the certificate prints it.
"""

from collections.abc import Callable
from typing import get_args

import numpy as np
import pytest

from schemas.calibration import Calibration, Item, UncertaintyKind
from schemas.recording import Recording
from tasks.certificate.fields import slug
from tasks.certificate.statements import evaluation, readings, uncertainty
from tasks.conformity import decide
from tasks.motion.table import EARTH_RATE
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.readings import READINGS
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.monte_carlo import acquisition, combine_as_example
from tasks.words import say
from tests.manifests import at_station
from tests.tasks.items_only import items_only

AXES = "xyz"
DEG = float(np.degrees(1.0))
GRAVITY = 9.78
LATITUDE = 39.9
OMEGA = np.radians(300.0)  # the largest rate of the ideal run
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
P = np.array([[0.0, 3e-5, -6e-5], [2e-5, 0.0, 5e-5], [-4e-5, 1e-5, 0.0]])  # m, model (2)

Build = Callable[..., Recording]


def result(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def item(recording: Recording, name: str) -> Item:
    return result(recording).items[name]


def means(recording: Recording, *names: str) -> np.ndarray:
    """Mean readings (n, 6) of the named segments."""
    found = {s.name: recording.imu.rows(s.t_start, s.t_end) for s in recording.manifest.segments}
    columns = np.array(list(recording.imu.columns.values()))
    return np.array([columns[:, found[name]].mean(axis=1) for name in names])


def off_diagonal(matrix: np.ndarray) -> dict[str, float]:
    return {AXES[i] + AXES[j]: matrix[i, j] for i in range(3) for j in range(3) if i != j}


def at_latitude(recording: Recording, latitude: float) -> Recording:
    return at_station(recording, latitude_deg=latitude)


def printed_readings(calibration: Calibration) -> str:
    """The readings of the specification as the certificate prints them, English."""
    return " ".join(
        say(text, "en") for each in readings(calibration) for text in (each.clause, each.text)
    )


# 1 and 2: eq. (12), (13), text and sign.


def test_eq_12_takes_one_mean_at_rest_and_one_while_turning(ideal_run):
    recording = ideal_run(P=P)
    value = item(recording, "accel_rate_sensitivity").value["yx"]
    assert value == pytest.approx(-P[1, 0], abs=1e-9)
    rest, rest_again = means(recording, "rest_x", "rest2_x")
    both_at_rest = (rest - rest_again)[4] / OMEGA**2  # as the text under (12) describes U_8
    assert abs(both_at_rest - value) > 1e-5


def test_eq_12_has_the_opposite_sign_of_model_2_and_both_are_stored(ideal_run):
    recording = ideal_run(P=P)
    p = item(recording, "accel_rate_sensitivity")
    assert p.value_model == pytest.approx(off_diagonal(P), abs=1e-9)
    assert p.value == pytest.approx(off_diagonal(-P), abs=1e-9)
    rest, turning = means(recording, "rest_x", "rate_x_+300")
    as_printed = (rest - turning)[4] / OMEGA**2
    assert p.value["yx"] == pytest.approx(as_printed, rel=1e-3)
    # Compensated with model (2), the turning mean must read what the rest reads.
    assert turning[4] - p.value_model["yx"] * OMEGA**2 == pytest.approx(rest[4], abs=1e-7)
    assert abs(turning[4] - as_printed * OMEGA**2 - rest[4]) > 1e-3


# 3: p is not the sensor's alone.


def test_eq_12_returns_the_lever_arm_on_top_of_p(ideal_run):
    r = np.array([0.010, 0.020, -0.030])
    arm = np.array([[0.0 if i == j else -r[i] for j in range(3)] for i in range(3)])
    recording = ideal_run(P=P + arm)  # turning about j, −ω²·r_i is felt along i
    value = item(recording, "accel_rate_sensitivity").value
    assert value["yx"] == pytest.approx(r[1] - P[1, 0], abs=1e-8)
    assert value["zx"] == pytest.approx(r[2] - P[2, 0], abs=1e-8)
    assert abs(value["yx"] + P[1, 0]) > 0.01  # the sensor's own p it is not
    assert "jjf2003.p_lever_arm" in item(recording, "accel_rate_sensitivity").readings


# 4: Earth's rotation in the g-sensitivity.


def test_eq_7_keeps_the_vertical_part_of_earths_rotation_and_it_is_removed(ideal_run):
    true = np.array([[0.004, 0.001, 0.0], [0.0, -0.006, 0.002], [0.003, 0.0, 0.005]])  # (°/s)/g
    vertical = DEG * EARTH_RATE * np.sin(np.radians(LATITUDE))
    felt = true + vertical * np.eye(3)  # an axis up reads +ω_e·sin φ, an axis down −ω_e·sin φ
    recording = at_latitude(ideal_run(G=np.radians(felt) / GRAVITY), LATITUDE)
    g = item(recording, "gyro_g_sensitivity")
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


# 5, 6, 7 and 11: slips of the pen, which decide what is called what.


@pytest.mark.parametrize("element", ["xz", "zx"])
def test_k_axz_and_k_azx_are_two_coefficients(ideal_run, element):
    coupling = np.eye(3)
    coupling[AXES.index(element[0]), AXES.index(element[1])] = 0.01
    value = item(ideal_run(Ka=coupling), "accel_cross_coupling").value
    assert {e for e, v in value.items() if abs(v) > 1e-6} == {element}
    assert len(value) == 6


def test_k_gzy_which_appendix_b_leaves_out_is_given(ideal_run):
    coupling = np.eye(3)
    coupling[2, 1] = 0.01
    calibration = result(ideal_run(Kg=coupling))
    value = calibration.items["gyro_cross_coupling"].value
    assert value["zy"] == pytest.approx(0.01, abs=1e-7)
    as_printed = ("yx", "zx", "xy", "xz", "yz")
    assert all(abs(value[element]) < 1e-7 for element in as_printed)


def test_both_names_of_the_input_matrix_are_one_matrix_in_local_g(ideal_run):
    calibration = result(ideal_run(Ka=1.01 * np.eye(3), G=0.001 * np.eye(3)))
    scale, g = calibration.items["accel_scale_factor"], calibration.items["gyro_g_sensitivity"]
    assert scale.value["x"] == pytest.approx(1.01, abs=1e-8)
    assert g.value["xx"] == pytest.approx(DEG * 0.001 * GRAVITY, abs=1e-7)
    in_si = DEG * 0.001  # had (7) taken its matrix in m/s²
    assert abs(g.value["xx"] - in_si) > 0.1


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


# 8: the unit of p.


def test_p_is_in_metres_and_its_unit_is_written_beside_it(ideal_run):
    p = item(ideal_run(P=P), "accel_rate_sensitivity")
    assert p.unit == "m"
    in_g_per_square_degree = P[1, 0] / GRAVITY / DEG**2
    assert p.value_model["yx"] == pytest.approx(P[1, 0], rel=1e-4)
    assert abs(p.value_model["yx"] - in_g_per_square_degree) > 1e-5


# 9 and 10: Appendix A.


def test_appendix_a_adds_linearly_what_its_own_law_of_propagation_does_not():
    u = 3.41e-5
    positions = [
        Contribution(InputQuantity(f"U{i}", "mean", "deg/s", u, "A", "normal"), 1 / 6)
        for i in range(6)
    ]
    gum = combine("gyro_bias", "deg/s", 0.0, positions)
    assert gum.u_c == pytest.approx(u / np.sqrt(6), rel=1e-12)
    as_printed = combine_as_example("gyro_bias", "deg/s", 0.0, [u] * 6).inputs[2].u
    assert as_printed == pytest.approx(2.046e-4, rel=1e-12)
    assert as_printed > 10 * gum.u_c


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
