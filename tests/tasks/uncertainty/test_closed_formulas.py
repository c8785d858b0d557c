"""Type B: the equipment's limits as standard uncertainties, and their sensitivities."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from schemas.laboratory import EquipmentLimit
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.specifications.evidence import solve
from tasks.specifications.jjf2003.positions import input_matrix
from tasks.uncertainty.budget import Contribution, combine, resolution
from tasks.uncertainty.equipment import (
    ARCSECOND,
    JJF1536,
    JJF2003,
    RATE,
    Equipment,
    ErrorLimit,
    with_limits,
    with_polled_encoders,
)
from tests.tasks.uncertainty import closed_formulas
from tests.tasks.uncertainty.closed_formulas import Weights

G = 9.8015
TENTH = math.radians(0.1)
MEAN = Weights(np.full(12, 1 / 12), np.full(6, 1 / 6), np.full(6, 1 / 6))
LYING = Weights(np.full(8, 1 / 12), np.full(4, 1 / 6), np.full(4, 1 / 6))
UP_DOWN = Weights(np.array([1, 1, -1, -1]) / 4, np.array([1, -1]) / 2, np.array([1, -1]) / 2)


NONE = Equipment()


def alone(limit: str, u: float = 1.0) -> Equipment:
    """Equipment of which only one limit is not zero; its standard uncertainty is u."""
    changed = {}
    for field in fields(Equipment)[1:]:
        known = getattr(JJF2003, field.name)
        if field.name == "creeps":
            continue
        half = u * math.sqrt(3.0) if field.name == limit else 0.0
        changed[field.name] = known and replace(known, half_width=half)
    rate = replace(RATE, half_width=u * math.sqrt(3.0) if limit == "rate" else 0.0)
    return Equipment(rates=((0.0, rate),), **changed)


def u_of(contributions: tuple[Contribution, ...]) -> float:
    return combine("y", "1", 0.0, contributions).u_c


def observed(up: str, heading: float, field: np.ndarray) -> np.ndarray:
    """A vector of n (E, N, U) in the unit whose axis `up` is vertical."""
    axis, sign = "xyz".index(up[1]), 1.0 if up[0] == "+" else -1.0
    vertical = np.eye(3)[axis] * sign
    level = np.roll(vertical, 1)
    east = level * math.cos(heading) + np.cross(vertical, level) * math.sin(heading)
    return np.column_stack([east, np.cross(vertical, east), vertical]) @ field


def scatter(field: np.ndarray, each: float, face: float) -> np.ndarray:
    """Scatter (3, 4) of eq. (7), (10) in twelve positions with random attitude errors (rad)."""
    rng, trials = np.random.default_rng(1), 3000
    ups = ("+x", "-x", "+y", "-y", "+z", "-z")
    means = []
    for up in ups:
        mounted = rng.normal(0.0, face, (trials, 3))
        turns = []
        for heading in (0.3, 0.3 + math.pi):
            straight = observed(up, heading, field)
            tilt = mounted + rng.normal(0.0, each, (trials, 3))
            turns.append(straight + np.cross(tilt, straight))
        means.append(np.mean(turns, axis=0))
    operator = solve(input_matrix(np.eye(6), np.array([unit_vector(up) for up in ups]))).operator
    return np.std(np.einsum("ju,uti->tij", operator, np.array(means)), axis=0)


@pytest.mark.parametrize(("sort", "each", "face"), [("position", 1e-4, 0), ("fixture", 0, 1e-4)])
def test_accelerometer_sensitivities_to_attitude_are_those_of_simulated_positions(sort, each, face):
    found = scatter(np.array([0.0, 0.0, G]), each, face)
    equipment = alone(sort, 1e-4)
    bias = u_of(closed_formulas.attitude_errors(equipment, G, LYING))
    assert np.mean(found[:, 3]) == pytest.approx(bias, rel=0.05)
    coupling = u_of(closed_formulas.attitude_errors(equipment, 1.0, UP_DOWN))
    off = np.mean(found[:, :3][~np.eye(3, dtype=bool)]) / G
    assert off == pytest.approx(coupling, rel=0.05)


@pytest.mark.parametrize(("sort", "each", "face"), [("position", 1e-4, 0), ("fixture", 0, 1e-4)])
def test_gyro_uncertainty_is_never_below_that_of_simulated_positions(sort, each, face):
    earth = EARTH_RATE * np.array([0.0, math.cos(0.7), math.sin(0.7)])
    found = scatter(earth, each, face)
    equipment = alone(sort, 1e-4)
    bias = u_of(closed_formulas.attitude_errors(equipment, EARTH_RATE, MEAN))
    sensitivity = u_of(closed_formulas.attitude_errors(equipment, EARTH_RATE, UP_DOWN))
    assert np.max(found[:, 3]) < 1.05 * bias
    assert np.max(found[:, :3]) < 1.05 * sensitivity
    assert np.max(found[:, 3]) > 0.4 * bias
    assert np.max(found[:, :3]) > 0.4 * sensitivity


def test_standard_uncertainties_of_table_1():
    root3 = math.sqrt(3.0)
    assert RATE.u == pytest.approx(1e-5 / root3)
    assert JJF2003.ripple is not None
    assert JJF2003.ripple.u == pytest.approx(5e-4 / root3)
    assert [limit.u for limit in JJF2003.angles] == pytest.approx(
        [10 * ARCSECOND / root3, 5 * ARCSECOND / root3]
    )
    for limit in (JJF2003.axes, JJF2003.fixture, JJF2003.level):
        assert limit is not None
        assert limit.u == pytest.approx(10 * ARCSECOND / root3)


@pytest.mark.parametrize(("deg_s", "u"), [(0.5, 1e-2), (1.0, 1e-3), (10.0, 1e-4), (-300.0, 1e-4)])
def test_jjf1536_rate_uncertainty_depends_on_the_rate(deg_s, u):
    (limit,) = JJF1536.rate_at(math.radians(deg_s))
    assert limit.u == pytest.approx(u)
    assert JJF1536.position is not None
    assert JJF1536.position.u == pytest.approx(5 * ARCSECOND)


@pytest.mark.parametrize(
    ("distribution", "divisor"),
    [("normal", 2.0), ("rectangular", 3**0.5), ("triangular", 6**0.5), ("arcsine", 2**0.5)],
)
def test_half_widths_are_divided_as_the_distribution_asks(distribution, divisor):
    limit = ErrorLimit("a", "a", "1", 6.0, distribution, "clause")
    assert limit.quantity.u == pytest.approx(6.0 / divisor)


def test_a_table_that_turns_too_fast_moves_the_scale_factor_and_not_the_offset():
    rates = np.radians([-300.0, -100.0, -10.0, 10.0, 100.0, 300.0])
    operator = solve(np.column_stack([rates, np.ones(6)])).operator
    fast, slow = 1.0 + 1e-5, 1.0
    k_true, seconds = 1.02, np.full(6, 60.0)
    error = operator @ (k_true * rates * fast) - operator @ (k_true * rates * slow)
    for row in range(2):
        lines = closed_formulas.turning_rate(
            alone("rate", 1e-5), k_true, operator[row], rates, seconds
        )
        assert u_of(lines) == pytest.approx(abs(error[row]), abs=1e-15)


def test_ripple_counts_by_its_rms_in_less_than_a_turn_and_fades_over_many():
    rates, operator = np.array([0.01, 10.0]), np.array([1.0, 0.0])
    ripple = alone("ripple")
    slow = u_of(closed_formulas.turning_rate(ripple, 1.0, operator, rates, np.array([10.0, 10.0])))
    assert slow == pytest.approx(0.01 / math.sqrt(2.0))
    fast = u_of(
        closed_formulas.turning_rate(ripple, 1.0, operator[::-1], rates, np.array([10.0, 10.0]))
    )
    assert fast == pytest.approx(10.0 / 100.0)


def test_gravity_moves_the_accelerometer_scale_factor():
    lines = closed_formulas.gravity_error(alone("gravity", 1e-3), 1.01, G)
    assert u_of(lines) == pytest.approx(1.01 * 1e-3 / G)


def test_latitude_counts_only_where_earth_rotation_was_removed():
    equipment, latitude = alone("latitude", TENTH), math.radians(39.9)
    assert u_of(closed_formulas.attitude_errors(equipment, EARTH_RATE, UP_DOWN)) == 0.0
    removed = u_of(closed_formulas.earth_removed(equipment, 1.0, latitude))
    change = EARTH_RATE * (math.sin(latitude + TENTH / 2) - math.sin(latitude - TENTH / 2))
    assert removed == pytest.approx(change, rel=1e-6)


def test_rate_sensitivity_follows_rate_and_tilt():
    p, rate = 0.02, math.radians(300.0)
    assert u_of(
        closed_formulas.accel_rate_sensitivity(alone("rate", 1e-3), p, rate, G)
    ) == pytest.approx(abs(p / 1.001**2 - p), rel=2e-3)
    tilt = u_of(closed_formulas.accel_rate_sensitivity(alone("position", 1e-4), p, rate, G))
    assert tilt == pytest.approx(1e-4 * G / rate**2)


def test_rotation_axis_reaches_a_cross_coupling_whole():
    assert u_of(closed_formulas.turning_axis(alone("fixture", 1e-4), 1.0, 0.0)) == pytest.approx(
        1e-4
    )


def test_jjf1536_items():
    equipment = JJF1536
    assert equipment.fixture is not None
    rates = np.radians([-100.0, 100.0])
    lines = closed_formulas.turning_rate(
        equipment, 1.0, rates / (rates @ rates), rates, np.full(2, 30.0)
    )
    assert u_of(lines) == pytest.approx(1.0e-4)
    offset = u_of(closed_formulas.ahrs_zero_offset(equipment, 1800.0))
    assert offset == pytest.approx(
        math.hypot(5 * ARCSECOND / 3600.0, EARTH_RATE / 2 * equipment.fixture.u)
    )
    turns = 20.0 * math.pi * np.array([1.0, -1.0])
    misalignment = closed_formulas.ahrs_misalignment(
        equipment, 0.1, 1.0, np.array([1.0, -1.0]), turns
    )
    table = 0.1 / (20.0 * math.pi) / math.sqrt(2.0) * 5 * ARCSECOND
    assert u_of(misalignment) == pytest.approx(math.hypot(table, 5 * ARCSECOND / math.sqrt(3.0)))


def test_rates_that_a_table_holds_differently_well_have_a_line_each():
    rates = np.radians([-100.0, -5.0, 5.0, 100.0])
    operator = rates / (rates @ rates)
    fast, slow = closed_formulas.turning_rate(JJF1536, 1.0, operator, rates, np.full(4, 30.0))
    assert (fast.quantity.u, slow.quantity.u) == pytest.approx((1e-4, 1e-3))
    assert fast.sensitivity + slow.sensitivity == pytest.approx(-1.0)
    assert slow.sensitivity == pytest.approx(-2 * 5.0**2 / (2 * 5.0**2 + 2 * 100.0**2))


def test_a_turned_angle_is_as_wrong_as_the_table():
    angles = math.pi * np.array([2.0, -2.0])
    lines = closed_formulas.turned_angle(alone("position", 1e-4), 1.0, angles)
    assert u_of(lines) == pytest.approx(1e-4 / (2 * math.pi) / math.sqrt(2.0))


def test_a_laboratory_s_own_limits_go_before_table_1():
    certified = EquipmentLimit(half_width=2e-6, distribution="normal", source="certificate 7")
    own = with_limits(JJF1536, {"rate": certified, "axes": certified})
    (rate,) = own.rate_at(0.001)
    assert (rate.u, rate.clause) == (1e-6, "certificate 7")
    assert own.axes is not None
    assert (own.axes.u, own.axes.symbol) == (1e-6, "α3")
    assert own.position == JJF1536.position


def test_a_table_that_nobody_knows_has_no_line():
    rates = np.radians([-100.0, 100.0])
    seconds = np.full(2, 30.0)
    assert closed_formulas.turning_rate(NONE, 1.0, rates / (rates @ rates), rates, seconds) == ()
    assert closed_formulas.attitude_errors(NONE, EARTH_RATE, MEAN) == ()
    assert closed_formulas.turning_axis(NONE, 1.0) == ()
    (gravity,) = closed_formulas.gravity_error(NONE, 1.0, G)
    assert gravity.quantity.symbol == "g"


def test_readings_are_each_rounded_by_an_error_of_their_own():
    step = 0.2
    line = resolution(step / 2.0, "deg/s", math.hypot(0.5, -0.5))
    assert u_of((line,)) == pytest.approx(step / math.sqrt(12.0) * math.sqrt(0.5))


def test_every_budget_of_the_default_equipment_is_finite_and_names_its_inputs_once():
    rates = np.radians([-100.0, 100.0])
    all_lines = (
        closed_formulas.turning_rate(
            JJF2003, 1.0, rates / (rates @ rates), rates, np.array([30.0, 30.0])
        ),
        closed_formulas.turning_axis(JJF2003, 1.0, 1e-3),
        closed_formulas.attitude_errors(JJF2003, EARTH_RATE, MEAN),
        closed_formulas.attitude_errors(JJF2003, EARTH_RATE, UP_DOWN),
        closed_formulas.attitude_errors(JJF2003, 1e-3, UP_DOWN)
        + closed_formulas.gravity_error(JJF2003, 1.0, G),
        closed_formulas.attitude_errors(JJF2003, 1.0, UP_DOWN)
        + closed_formulas.gravity_error(JJF2003, 1e-3, G),
        closed_formulas.attitude_errors(JJF2003, G, LYING),
        closed_formulas.accel_rate_sensitivity(JJF2003, 1e-4, 5.0, G),
    )
    for lines in all_lines:
        assert 0.0 < u_of(lines) < 1.0
    degrees = tuple(line.scaled(math.degrees(1.0)) for line in all_lines[2])
    assert u_of(degrees) == pytest.approx(math.degrees(u_of(all_lines[2])))


def test_one_mounting_reaches_couplings_whole_and_cancels_in_the_bias():
    ups = ("+x", "-x", "+y", "-y", "+z", "-z")
    design = input_matrix(np.eye(6), np.array([unit_vector(up) for up in ups]))
    operator, fixture = solve(design).operator, np.array([1e-4, -2e-4, 3e-4])
    reads = np.cross(fixture, G * design[:, :3])
    found = operator @ reads / G
    equipment = alone("fixture", 1e-4)
    for column, expected in ((0, 1e-4), (3, 0.0)):
        signs = operator[column] @ design[:, :3]
        weights = Weights(np.zeros(12), operator[column], signs)
        attitude = u_of(closed_formulas.attitude_errors(equipment, 1.0, weights))
        assert attitude == pytest.approx(expected, abs=1e-12)
    assert np.abs(found[0]) == pytest.approx([0.0, 3e-4, 2e-4], abs=1e-12)
    assert np.abs(found[3]).max() < 1e-15


@pytest.mark.parametrize("deg_s", [10.0 - 1e-9, 9.95, 10.0])
def test_a_rate_just_below_the_edge_of_a_class_belongs_to_it(deg_s):
    (limit,) = JJF1536.rate_at(math.radians(deg_s))
    assert limit.symbol == "ε1"


def test_times_of_polled_encoders_reach_a_line_through_its_mean_rates():
    """Beginning and end of every point are off by times of their own, as drawn here."""
    polled, rng = with_polled_encoders(NONE, 5e-3), np.random.default_rng(1)
    rates, seconds = np.radians([-100.0, -10.0, 10.0, 100.0]), np.array([10.0, 36.0, 36.0, 10.0])
    operator = rates / (rates @ rates)  # of U = slope·X through zero
    (line,) = closed_formulas.turning_rate(polled, 1.0, operator, rates, seconds)
    begin, end = rng.uniform(-5e-3, 5e-3, (2, 20_000, 4))
    slopes = (rates * (1.0 + (end - begin) / seconds)) @ operator
    assert u_of((line,)) == pytest.approx(slopes.std(), rel=0.02)
