"""Every element of both specifications has a budget; one coverage factor stands for an item."""

import math

import GTC
import numpy as np
import pytest

from schemas.base import Unusable
from schemas.calibration import Budget, Calibration, Item
from schemas.laboratory import EquipmentLimit
from schemas.recording import Recording
from tasks.calibrate.calibrate import common_factor, evaluation_for, expanded
from tasks.motion.table import EARTH_RATE
from tasks.segments.rates import rate_by_command
from tasks.specifications.register import specification_for
from tasks.uncertainty.budget import combine, observed
from tasks.uncertainty.monte_carlo import acquisition
from tests.manifests import at_station, described
from tests.tasks.items_only import items_only

# Every element of both specifications has a budget; a laboratory may choose how it is made.

EXAMPLE = "as the specification's example"
AGREES = 1e-6


HOLDS = {"commanded_rate": {"half_width": 1e-5, "distribution": "rectangular"}}


def calibrated(recording: Recording, **how) -> Calibration:
    specification = specification_for(recording.manifest.standard)
    evaluation = evaluation_for(recording, **how)
    return items_only(specification, recording, evaluation)


def budgets(calibration: Calibration) -> dict[str, Budget]:
    return {
        f"{name}.{element}": budget
        for name, item in calibration.items.items()
        for element, budget in item.budgets.items()
    }


@pytest.fixture(scope="module")
def calibrations(ideal_run, ahrs_noise, plant) -> dict[str, Calibration]:
    recordings = {
        "ideal": ideal_run(noise=1e-4),
        "ahrs": ahrs_noise,
        "plant_clean": plant("plant_clean", 4),
        "ahrs_clean": described(plant("ahrs_clean"), table_time=HOLDS),
    }
    return {name: calibrated(recording) for name, recording in recordings.items()}


@pytest.fixture(scope="module")
def ahrs_noise(plant) -> Recording:
    """An AHRS whose recording tells no latitude."""
    return described(at_station(plant("ahrs_clean"), latitude_deg=None), table_time=HOLDS)


def test_every_element_with_a_value_has_a_budget_that_gives_its_u(calibrations):
    for calibration in calibrations.values():
        for name, item in calibration.items.items():
            assert item.uncertainty_kind == "GUM"
            assert set(item.budgets) == {e for e, value in item.value.items() if value is not None}
            for element, budget in item.budgets.items():
                assert budget.result == f"{name}.{element}"
                assert (budget.value, budget.u_c) == (item.value[element], item.u[element])
                assert (budget.U, budget.k) == (item.U[element], item.k)
                assert budget.U / item.k == pytest.approx(budget.u_c)
                assert budget.unit == item.unit
                assert sum(line.share for line in budget.inputs) == pytest.approx(1.0)
                kinds = {line.kind for line in budget.inputs}
                assert {"A"} <= kinds <= {"A", "B"}  # what the equipment does may cancel in a bias


def test_gtc_agrees_on_every_budget_of_a_calibration(calibrations):
    checked = 0
    for calibration in calibrations.values():
        for name, budget in budgets(calibration).items():
            judge = GTC.ureal(budget.value, 0.0)
            for line in budget.inputs:
                judge = judge + line.sensitivity * GTC.ureal(0.0, line.u, line.dof)
            assert budget.u_c == pytest.approx(GTC.uncertainty(judge), rel=AGREES), name
            assert budget.dof == pytest.approx(GTC.dof(judge), rel=AGREES), name
            checked += 1
    assert checked == 2 * 42 + 2 * 12


def test_few_degrees_of_freedom_enlarge_the_coverage_factor_of_the_whole_item(real):
    recording = described(real("vn200_imu0_rate_table"), table_time=HOLDS)
    item = calibrated(recording).items["gyro_scale_factor"]
    fewest = min(budget.dof for budget in item.budgets.values())
    assert fewest < 3
    t = GTC.reporting.k_factor(math.floor(fewest), 100 * math.erf(math.sqrt(2.0)))
    assert t <= item.k < t + 0.01 + 1e-9
    assert item.k == round(item.k, 2)


def test_many_degrees_of_freedom_leave_the_factor_two(calibrations):
    item = calibrations["plant_clean"].items["accel_cross_coupling"]
    assert all(budget.dof > 50 for budget in item.budgets.values())
    assert item.k == 2.0


def test_the_repeatability_has_the_degrees_of_freedom_of_its_noise(calibrations):
    for name, budget in budgets(calibrations["plant_clean"]).items():
        (line,) = [each for each in budget.inputs if each.kind == "A"]
        assert 5 < line.dof < 1000, name
        assert line.distribution == "t"


def test_scatter_beyond_the_noise_has_the_degrees_of_freedom_of_the_residuals(real):
    calibration = calibrated(real("ferraris_session"))
    assert "excess_scatter" in {remark.code for remark in calibration.remarks}
    line = calibration.items["accel_bias"].budgets["x"].inputs[0]
    assert line.dof == 6 - 4  # six positions, three inputs and a bias


def test_the_value_without_earth_rotation_has_the_latitude_in_its_own_uncertainty(plant):
    limit = EquipmentLimit(half_width=0.1, distribution="rectangular", source="a map")
    recording = plant("plant_clean", 4)
    item = calibrated(recording, own={"latitude": limit}).items["gyro_g_sensitivity"]
    phi = np.radians(recording.manifest.station.latitude_deg)
    line = np.degrees(EARTH_RATE * np.cos(phi) * 0.1 / np.sqrt(3.0))
    for a in "xyz":
        expected = np.hypot(item.u[a + a], line)
        assert item.u_without_earth_rotation[a + a] == pytest.approx(expected, rel=0.01)
        assert item.U_without_earth_rotation[a + a] == pytest.approx(item.k * expected, rel=0.01)
    assert item.u_without_earth_rotation["xy"] == pytest.approx(item.u["xy"], rel=0.01)


def test_a_recording_of_no_specification_counts_no_table_and_says_so(ideal_run):
    calibration = calibrated(described(ideal_run(), standard="other"))
    (remark,) = [r for r in calibration.remarks if r.code == "equipment_unknown"]
    assert remark.blocks_pass
    symbols = {line.symbol for b in budgets(calibration).values() for line in b.inputs}
    assert symbols <= {"u_A", "g", "q", "ωN", "ε5"}  # what the manifest states of its rates
    without_u = calibration.items["accel_cross_coupling"]  # hangs on angles that nobody states
    assert not without_u.budgets
    assert set(without_u.repeatability or ()) == set(without_u.value)
    assert "reference_unstated" in {r.code for r in calibration.remarks}
    assert calibration.settings["limits"] == "table and fixture not known"


def test_a_laboratory_s_own_limits_are_used_and_named(ideal_run):
    own = EquipmentLimit(half_width=1e-3, distribution="rectangular", source="certificate 7")
    calibration = calibrated(ideal_run(), own={"rate": own})
    assert calibration.settings["limit of rate"] == "0.001 (certificate 7)"
    u = calibration.items["gyro_scale_factor"].u["x"]
    assert u == pytest.approx(1e-3 / math.sqrt(3.0), rel=1e-3)


def test_a_coarse_step_is_a_line_of_its_own(ideal_run):
    recording = ideal_run(noise=0.0015, Ba=np.array([0.004, 0.003, 0.002]))
    step = 0.01
    columns = dict(recording.imu.columns)
    for name in ("accel_x", "accel_y", "accel_z"):
        columns[name] = step * np.round(columns[name] / step)
    stream = type(recording.imu)(recording.imu.t, columns)
    coarse = Recording(recording.manifest, stream, environment=recording.environment, digest="1")
    budget = calibrated(coarse).items["accel_bias"].budgets["x"]
    (line,) = [each for each in budget.inputs if each.symbol == "q"]
    assert line.kind == "B"
    # Noise of 0.15 of a step leaves less than half of it; four of six positions lie on one code.
    undithered = step / math.sqrt(12.0)
    assert 0.3 * undithered / math.sqrt(6.0) < line.u < math.sqrt(0.41 * 18.0) / 6.0 * undithered


SUMMED = {  # item: how many positions the appendix adds up, and what each counts
    "gyro_scale_factor": (1, 1.0), "gyro_bias": (6, 1.0), "gyro_g_sensitivity": (2, 1.0),
    "accel_bias": (6, 1.0), "accel_rate_sensitivity": (2, 1.0),
}  # fmt: skip


@pytest.fixture(scope="module")
def as_the_example(plant) -> Calibration:
    return calibrated(plant("plant_clean", 4), kind=EXAMPLE)


@pytest.mark.parametrize("item", SUMMED)
def test_as_the_example_the_positions_are_added_linearly(calibrations, as_the_example, item):
    example = as_the_example.items[item]
    gum = calibrations["plant_clean"].items[item]
    count, _ = SUMMED[item]
    assert example.uncertainty_kind == EXAMPLE
    assert example.k == 2.0
    for element, budget in example.budgets.items():
        u1, u2, u3 = budget.inputs
        assert (u1.u, u2.u) == (1.0e-4, acquisition(12))
        repeated = gum.budgets[element].inputs[0].u
        # Summed, they are √n·n times the mean's independent part, and less where drift is common.
        assert u3.u >= 0.99 * repeated
        assert (u3.u > 1.3 * repeated) == (count > 1)
        assert budget.half_width_95 is None


def test_as_the_example_the_unit_s_own_bits_are_used_where_they_are_told(ideal_run):
    recording = ideal_run()
    plain = calibrated(recording, kind=EXAMPLE)
    assert plain.settings["effective bits"] == "12 (the example's)"
    unit = recording.manifest.unit
    finer = type(unit).model_validate({**dict(unit), "effective_bits": 16})
    fine = described(recording, unit=finer)
    calibration = calibrated(fine, kind=EXAMPLE)
    assert calibration.settings["effective bits"] == "16 (the unit's)"
    assert calibration.items["gyro_bias"].budgets["x"].inputs[1].u == acquisition(16)


@pytest.mark.parametrize("bits", [0, "twelve", True, 1e9])
def test_bits_that_are_no_number_of_bits_are_refused(ideal_run, bits):
    recording = ideal_run()
    unit = recording.manifest.unit
    wrong = described(
        recording, unit=type(unit).model_validate({**dict(unit), "effective_bits": bits})
    )
    with pytest.raises(Unusable, match="effective_bits"):
        evaluation_for(wrong)


def test_the_same_recording_gives_the_same_budgets_to_the_last_digit(ideal_run):
    recording = ideal_run(noise=1e-4)
    assert budgets(calibrated(recording)) == budgets(calibrated(recording))


def test_a_result_of_before_there_were_budgets_is_still_read(ideal_run):
    old = calibrated(ideal_run()).model_dump(mode="json")
    for item in old["items"].values():
        del item["budgets"], item["u_without_earth_rotation"], item["U_without_earth_rotation"]
        item |= {"uncertainty_kind": "type A", "k": 2.0}
    old["settings"] = {"gravity_m_s2": 9.8, "latitude_deg": 0.0}
    assert Calibration.model_validate(old).items["gyro_bias"].budgets == {}


def test_as_the_example_an_element_without_repeatability_has_no_uncertainty(real):
    bias = calibrated(real("vn200_imu1_rate_table"), kind=EXAMPLE).items["accel_bias"]
    assert bias.value["x"] is not None
    assert bias.U["x"] is None


@pytest.mark.parametrize("method", ["jjf2003", "joint"])
def test_what_is_known_of_a_polled_encoders_time_is_in_the_budget_of_the_rates(plant, method):
    recording = plant("plant_clean", 4)
    polled = described(recording, table_time={"encoder": "polled", "half_width_s": 0.01})
    evaluation = evaluation_for(polled)
    specification = specification_for("other", method)
    item = items_only(specification, polled, evaluation).items["gyro_scale_factor"]
    for element in "xyz":
        (line,) = (each for each in item.budgets[element].inputs if each.symbol == "τ")
        assert (line.half_width, line.unit, line.distribution) == (0.01, "s", "rectangular")
        assert 1e-5 < line.u * abs(line.sensitivity) < 1e-3


@pytest.mark.parametrize("method", ["jjf2003", "joint"])
def test_a_commanded_rate_that_is_known_better_is_the_reference_with_its_own_limit(plant, method):
    recording, specification = plant("plant_clean", 4), specification_for("other", method)

    def item(half_width_s: float, within: float) -> Item:
        bound = {"half_width": within, "distribution": "rectangular"}
        table_time = {"half_width_s": half_width_s, "commanded_rate": bound}
        polled = described(recording, table_time=table_time)
        return items_only(specification, polled, evaluation_for(polled)).items["gyro_scale_factor"]

    (better, worse), clean = (item(0.05, 2e-5), item(1e-5, 1e-3)), item(0.0, 2e-5)
    for element in "xyz":
        symbols = {line.symbol: line for line in better.budgets[element].inputs}
        assert "τ" not in symbols
        assert symbols["ε5"].half_width == 2e-5
        assert abs(symbols["ε5"].sensitivity) == pytest.approx(1.0, rel=0.02)
        assert {line.symbol for line in worse.budgets[element].inputs} & {"τ", "ε5"} == {"τ"}
        assert abs(better.value[element] - clean.value[element]) < better.U[element]


def test_a_commanded_rate_that_the_angles_contradict_is_none(plant):
    recording = plant("plant_clean", 4)
    bound = {"half_width": 2e-5, "distribution": "rectangular"}
    for half_width_s, is_believed in ((0.05, True), (1e-3, False)):
        polled = described(
            recording, table_time={"half_width_s": half_width_s, "commanded_rate": bound}
        )
        segment = next(s for s in recording.manifest.segments or () if s.kind == "rate")
        off = segment.model_copy(update={"rate_deg_s": segment.rate_deg_s * 1.001})
        assert rate_by_command(polled, segment) is not None, half_width_s
        assert (rate_by_command(polled, off) is not None) is is_believed


@pytest.mark.parametrize("stated", ["polled", {}, {"half_width_s": -1.0}, {"half_width_s": "0.1"}])
def test_a_polled_encoders_time_that_is_none_is_refused(plant, stated):
    with pytest.raises(Unusable, match=r"table_time\.half_width_s is"):
        evaluation_for(described(plant("plant_clean", 4), table_time=stated))


# One coverage factor for the elements of an item.


def of_dof(dof: float):
    return combine("b.x", "1", 1.0, [observed(0.5, "1", dof)])


def test_the_element_of_the_fewest_degrees_of_freedom_sets_the_factor_of_all():
    budgets = {"x": of_dof(5.0), "y": of_dof(200.0), "z": of_dof(12.0)}
    k = common_factor(budgets)
    assert k == 2.65  # Student's t of 5 dof at 95.45 %, 2.6487, rounded up
    stated = expanded(budgets["y"], k)
    assert (stated.k, stated.U) == (k, pytest.approx(2.65 * 0.5))


def test_fifty_degrees_of_freedom_are_enough_for_two():
    assert common_factor({"x": of_dof(50.0), "y": of_dof(1e4)}) == 2.0
    assert common_factor({"x": of_dof(49.0), "y": of_dof(1e4)}) > 2.0
