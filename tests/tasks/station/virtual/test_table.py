"""The virtual table by itself: ramps, servo, settling, encoders, safety."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from schemas.recording import TableAxis
from tasks.station.virtual.config import AXIS_STATUS, MODES, TABLE_STATUS, TableDesign
from tasks.station.virtual.table import VirtualTable, to_angle, to_rate

DEG = np.pi / 180.0


def ordered(mode: str, angle: float = 0.0, rate: float = 100.0) -> VirtualTable:
    table = VirtualTable(TableDesign())
    send(table, mode, angle, rate)
    return table


def send(table: VirtualTable, mode: str, angle: float = 0.0, rate: float = 100.0) -> None:
    drive = table.drives[1]
    drive.target_angle, drive.target_rate = angle * DEG, rate * DEG
    table.command(1, MODES[mode])


def settled(table: VirtualTable) -> bool:
    return bool(table.axis_status(1) & AXIS_STATUS["settled"])


@pytest.mark.parametrize(
    "orders",
    [
        [("rate", 0, 300)],
        [("angle", 90, 100)],
        [("angle", 3, 100)],
        [("rate", 0, 200), ("angle", 10, 50)],
        [("rate", 0, 100), ("rate", 0, -100)],
    ],
)
def test_ramps_keep_the_acceleration_limit(orders):
    table = VirtualTable(TableDesign())
    angles = [np.zeros((1, 3))]
    for order in orders:
        send(table, *order)
        angles.append(table.advance(4000))
    acceleration = np.diff(np.concatenate(angles)[:, 1], 2) / 1e-6 / DEG
    assert np.abs(acceleration).max() <= 100.0
    assert np.abs(acceleration).max() > 85.0


def test_axis_settles_on_its_angle_and_only_after_half_a_second_there():
    table = ordered("angle", angle=90.0, rate=100.0)
    angles, settled_at = [], None
    for step in range(4000):
        angles.append(table.advance(1)[0, 1])
        if settled(table):
            settled_at = step
            break
    error = np.abs(np.array(angles) - 90.0 * DEG)
    assert settled_at is not None
    assert (error[-500:] < 2.0 / 3600.0 * DEG).all()
    assert (error[:-501] >= 2.0 / 3600.0 * DEG).any()
    table.advance(2000)
    assert table.angle[1] == pytest.approx(90.0 * DEG, abs=1e-10)
    assert settled(table)


def test_axis_settles_on_its_rate():
    table = ordered("rate", rate=-300.0)
    table.advance(2500)
    assert not settled(table)
    table.advance(2500)
    assert settled(table)
    assert table.rate[1] == pytest.approx(-300.0 * DEG, rel=1e-6)
    assert table.axis_status(1) & AXIS_STATUS["moving"]


def test_the_axis_lags_behind_a_step_of_acceleration_like_an_8_hz_servo():
    table = ordered("rate", rate=300.0)
    angle = table.advance(1000)[-1, 1]
    asked = 0.5 * (100.0 / 1.1) * DEG  # ½·a·t² at 1 s
    omega = 2.0 * np.pi * 8.0
    # A ramp of rate: the lag tends to (2ζ/ω)·v + (1 − 4ζ²)/ω²·a.
    acceleration = (100.0 / 1.1) * DEG
    lag = 2 * 0.7 / omega * acceleration + (1 - 4 * 0.7**2) / omega**2 * acceleration
    assert asked - angle == pytest.approx(lag, rel=1e-3)


@pytest.mark.parametrize("bit", ["emergency_stop", "interlock", "fault"])
def test_a_tripped_table_ramps_to_rest_and_refuses_until_reset(bit):
    table = ordered("rate", rate=100.0)
    table.advance(3000)
    table.trip({bit})
    table.advance(200)
    assert 10.0 * DEG < table.rate[1] < 100.0 * DEG  # with the ramp, not at once
    table.advance(3000)
    send(table, "rate", rate=50.0)
    table.advance(3000)
    assert abs(table.rate[1]) < 1e-9
    assert table.drives[1].mode == MODES["stop"]
    assert table.axis_status(1) & AXIS_STATUS[bit]
    assert table.status() & TABLE_STATUS[bit]
    assert not table.status() & TABLE_STATUS["ready"]
    table.reset()
    send(table, "rate", rate=50.0)
    table.advance(3000)
    assert table.rate[1] == pytest.approx(50.0 * DEG, rel=1e-6)


def test_a_table_has_as_many_axes_as_it_was_given():
    table = VirtualTable(TableDesign(axes=(TableAxis(name="only", direction=(0, 0, 1)),)))
    assert table.advance(10).shape == (10, 1)


def test_motion_does_not_depend_on_how_time_is_cut():
    whole, cut = ordered("angle", angle=50.0), ordered("angle", angle=50.0)
    at_once = whole.advance(3000)
    pieces = np.concatenate([cut.advance(steps) for steps in (1, 9, 990, 1500, 500)])
    np.testing.assert_allclose(pieces, at_once, atol=1e-11)


moves = st.floats(-700.0, 700.0)


@example(start=0.0, rate=700.0, target=0.0, speed=0.01, limit=1.1)
@given(start=moves, rate=moves, target=moves, speed=st.floats(0.01, 500.0), limit=st.floats(1, 500))
def test_any_profile_to_an_angle_ends_there_within_its_limits(start, rate, target, speed, limit):
    profile = to_angle(5.0, start, rate, target, speed, limit)
    end = np.array([profile.t[-1] + 1.0])
    (angle,), (last_rate,) = profile.at(end)
    turned = abs(target - start) + rate**2 / limit  # deg, there and back, whose rounding adds up
    assert angle == pytest.approx(target, abs=1e-6 + 1e-11 * turned)
    assert last_rate == 0.0
    assert np.abs(profile.acceleration).max() <= limit * (1 + 1e-12)
    assert np.abs(profile.rate).max() <= max(speed, abs(rate)) * (1 + 1e-9)
    assert (np.diff(profile.t) >= 0).all()
    ends = profile.rate[:-1] + np.diff(profile.t) * profile.acceleration[:-1]
    np.testing.assert_allclose(ends, profile.rate[1:], atol=1e-6 * (1 + abs(rate)))


@given(rate=moves, target=moves, limit=st.floats(1, 500))
def test_any_profile_to_a_rate_takes_the_shortest_time(rate, target, limit):
    profile = to_rate(0.0, 0.0, rate, target, limit)
    assert profile.t[-1] == pytest.approx(abs(target - rate) / limit)
    assert profile.rate[-1] == target
