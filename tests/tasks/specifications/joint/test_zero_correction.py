"""The two steps as operators: what they are, and the patent's whole procedure."""

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import ACCEL, AXES, GYRO, Recording, Stream
from tasks.specifications.joint import JOINT
from tasks.specifications.joint.solution import Solved, least_squares, zero_corrected
from tests.manifests import manifest_of
from tests.tasks.items_only import items_only

GRAVITY = 9.8
RATES = (20.0, 60.0, 150.0, 300.0)
RATE_HZ = 10.0
ORIENTATIONS = [(axis, sign) for axis in range(3) for sign in (1, -1)]


def patent_run(
    unit: dict[str, np.ndarray], rates: tuple[float, ...] = RATES, seed: int = 1
) -> Recording:
    """Six orientations: in each, forward and back at rising rates, and then a rest."""
    rng = np.random.default_rng(seed)
    rows, segments, t = [], [], 0.0

    def hold(label: dict, rate: np.ndarray, force: np.ndarray) -> None:
        nonlocal t
        gyro = unit["Kg"] @ rate + unit["Bg"] + unit["G"] @ force / GRAVITY
        accel = unit["Ka"] @ force + unit["Ba"] + unit["P"] @ rate**2
        read = np.concatenate([gyro, accel]) + 1e-5 * rng.standard_normal((300, 6))
        rows.append(read)
        segments.append({**label, "t_start": t, "t_end": t + 30.0})
        t += 30.0

    for axis, sign in ORIENTATIONS:
        up = sign * np.eye(3)[axis]
        mark = ("+" if sign > 0 else "-") + AXES[axis]
        for rate in rates:
            for turn in (1, -1):
                about = turn * rate * np.eye(3)[axis]
                label = {"name": f"rate_{mark}_{turn * rate:+.0f}", "kind": "rate", "up": mark,
                         "axis": AXES[axis], "rate_deg_s": turn * rate}  # fmt: skip
                hold(label, np.radians(about), GRAVITY * up)
        hold({"name": f"rest_{mark}", "kind": "static", "up": mark}, np.zeros(3), GRAVITY * up)
    manifest = manifest_of(
        "patent", {"gravity_m_s2": GRAVITY}, standard="JJF 2003-2022", segments=segments
    )
    values = np.concatenate(rows)
    times = np.round(np.arange(len(values)) / RATE_HZ, 9)
    columns = dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))
    return Recording(manifest, Stream(times, columns), digest="0" * 64)


def unit(seed: int = 3) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    p = 1e-3 * rng.standard_normal((3, 3))
    np.fill_diagonal(p, 0.0)
    return {
        "Kg": np.eye(3) + 0.01 * rng.standard_normal((3, 3)),
        "Bg": 0.01 * rng.standard_normal(3),
        "G": 1e-3 * rng.standard_normal((3, 3)),
        "Ka": np.eye(3) + 0.01 * rng.standard_normal((3, 3)),
        "Ba": 0.1 * rng.standard_normal(3),
        "P": p,
    }


def codes(calibration: Calibration) -> set[str]:
    return {remark.code for remark in calibration.remarks}


def test_the_patents_procedure_gives_every_item_and_no_remark_on_its_claims():
    planted = unit()
    found = items_only(JOINT, patent_run(planted))
    named = {
        "gyro_g_sensitivity": np.degrees(planted["G"]),
        "accel_rate_sensitivity": -planted["P"],
        "gyro_cross_coupling": planted["Kg"],
        "accel_cross_coupling": planted["Ka"],
    }
    for name, true in named.items():
        item = found.items[name]
        for element, value in item.value.items():
            i, j = ("xyz".index(letter) for letter in element)
            assert abs(value - true[i, j]) < 4 * item.u[element], (name, element)
    for name, true in (("gyro_bias", np.degrees(planted["Bg"])), ("accel_bias", planted["Ba"])):
        assert list(found.items[name].value.values()) == pytest.approx(true, abs=1e-4)
    claims = {"number_of_rates", "orientations_not_turned", "rates_not_rising"}
    assert not claims & codes(found)


def test_too_few_or_falling_rates_are_remarked():
    few = items_only(JOINT, patent_run(unit(), (20.0, 300.0)))
    assert "number_of_rates" in codes(few)
    falling = items_only(JOINT, patent_run(unit(), RATES[::-1]))
    assert "rates_not_rising" in codes(falling)


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rates (n, 3) with 12 rests first, forces (n, 3) in g, and a covariance that drifts."""
    rng = np.random.default_rng(seed)
    rates = np.vstack([np.zeros((12, 3)), 2.0 * rng.standard_normal((20, 3))])
    forces = rng.standard_normal((32, 3))
    t = np.arange(32.0)
    drifting = np.exp(-np.abs(t[:, None] - t[None, :]) / 10.0)
    return rates, forces, np.eye(32) + drifting


def corrected(rates: np.ndarray, forces: np.ndarray, *rest: np.ndarray) -> Solved:
    """Three elements of K, the bias, three of the g-sensitivity."""
    design = np.hstack([rates, np.ones((len(rates), 1)), forces])
    roles = ("dynamic",) * 3 + ("bias",) + ("g-sensitivity",) * 3
    return zero_corrected(design, roles, *rest)


def test_repeating_the_two_steps_ends_where_the_operator_is():
    """Step 1 with the g-sensitivity put in, step 2 with step 1 put in, from nothing, by hand."""
    rates, forces, covariance = drawn(1)
    means = np.random.default_rng(2).standard_normal(32)
    everything, rests = np.ones(32, bool), np.arange(32) < 12
    weight, at_rest = (np.linalg.inv(covariance[np.ix_(w, w)]) for w in (everything, rests))
    ones = np.ones((32, 1))
    k, g = np.zeros(3), np.zeros(3)
    for _ in range(3):
        design, read = np.hstack([rates, ones]), means - forces @ g
        spread = np.eye(32) - forces @ _from_rests(ones, forces, at_rest)[1:] @ np.eye(32)[:12]
        weight = np.linalg.pinv(spread @ covariance @ spread.T, rcond=1e-12, hermitian=True)
        k = np.linalg.lstsq(design.T @ weight @ design, design.T @ weight @ read, rcond=None)[0][:3]
        b, *g = _from_rests(ones, forces, at_rest) @ (means - rates @ k)[:12]
        g = np.array(g)
    solved = corrected(rates, forces, everything, rests, means, covariance)
    found = solved.operator @ means
    assert found[3:] == pytest.approx([b, *g], rel=1e-6)
    assert found[:3] == pytest.approx(k, rel=1e-6)


def _from_rests(ones: np.ndarray, forces: np.ndarray, weight: np.ndarray) -> np.ndarray:
    design = np.hstack([ones, forces])[:12]
    return np.linalg.solve(design.T @ weight @ design, design.T @ weight)


def test_what_is_put_in_comes_out_of_the_operator():
    rates, forces, covariance = drawn(4)
    k, b, g = np.array([1.0, 0.01, -0.02]), 0.3, np.array([0.1, -0.2, 0.05])
    means = rates @ k + b + forces @ g
    rests = np.arange(32) < 12
    solved = corrected(rates, forces, np.ones(32, bool), rests, means, covariance)
    assert solved.operator @ means == pytest.approx([*k, b, *g], abs=1e-7)
    assert all(excess.factor == 1.0 for excess in solved.excess)


def test_without_rests_the_turns_alone_give_the_scale_factors():
    rates, forces, covariance = drawn(5)
    means = rates @ [1.0, 0.01, -0.02] + 0.3
    none = np.zeros(32, bool)
    solved = corrected(rates, forces, np.arange(32) >= 12, none, means, covariance)
    assert solved.operator[:3] @ means == pytest.approx([1.0, 0.01, -0.02], abs=1e-9)
    assert np.isnan(solved.operator[3:]).all()


def test_means_that_drift_together_count_less():
    ones, means = np.ones((3, 1)), np.zeros(3)
    together = np.array([[1.0, 0.99, 0.0], [0.99, 1.0, 0.0], [0.0, 0.0, 1.0]])
    weights = least_squares(ones, np.ones(3, bool), means, together).operator[0]
    assert weights == pytest.approx([0.25, 0.25, 0.5], abs=0.01)


def test_a_channel_that_stood_still_is_not_the_truth():
    ones, means = np.ones((4, 1)), np.zeros(4)
    weights = least_squares(ones, np.ones(4, bool), means, np.diag([0.0, 1.0, 1.0, 1.0])).operator
    assert weights[0, 0] < 0.8
