"""What a station can make a procedure of follows from its table and from the unit's warmth."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.laboratory import ChamberLimits
from schemas.procedure import EnvironmentLimits
from schemas.recording import Mount, Recording, Station, Stream, TableAxis
from tasks.experiment.blocks import Abilities, attitudes, blocks_of, room_of, upward
from tasks.experiment.track import USUAL_LAG, ThermalResponse
from tests.tasks.experiment.test_track import MANIFEST

# What a station can make a procedure of follows from its table.

VERTICAL, EAST = TableAxis(name="a", direction=(0, 0, 1)), TableAxis(name="b", direction=(1, 0, 0))
LEVEL, INNER = Mount(), TableAxis(name="c", direction=(0, 0, 1))


def able(*axes: TableAxis, mount: Mount = LEVEL, endless: bool = True) -> Abilities:
    station = Station(id="T", heading_deg=0.0, table_axes=axes)
    return Abilities(station, mount, (300.0,) * len(axes), 500.0, (endless,) * len(axes))


def test_three_axes_bring_every_axis_of_the_unit_up_and_down():
    found = attitudes(able(VERTICAL, EAST, INNER))
    assert [one.up for one in found] == ["+x", "-x", "+y", "-y", "+z", "-z"]


def test_one_vertical_axis_leaves_up_what_is_up():
    assert [one.up for one in attitudes(able(VERTICAL))] == ["+z"]
    lying = Mount(quaternion_wxyz=(0.5**0.5, 0.5**0.5, 0.0, 0.0))
    assert [one.up for one in attitudes(able(VERTICAL, mount=lying))] == ["+y"]


def test_each_axis_is_swung_by_the_vertical_axis_no_faster_than_it_turns():
    swings = [one for one in blocks_of(able(VERTICAL, EAST, INNER)) if "swing" in one.name]
    assert {step.axis for block in swings for step in block.steps} == {"x", "y", "z"}
    rates = [rate for block in swings for step in block.steps for rate in step.rates_deg_s]
    assert max(map(abs, rates)) == 300.0
    assert min(rates) < 0.0 < max(rates)
    for block in swings:
        for step in block.steps:
            assert len(set(step.rates_deg_s)) == len(step.rates_deg_s)


def of_magnitude(rates: tuple[float, ...]) -> float:
    """Sum of squares of |ω| that an offset, a scale factor and a square leave of it."""
    rate = np.array(rates) / 300.0
    others = np.vander(rate, 3)
    left = np.abs(rate) - others @ np.linalg.lstsq(others, np.abs(rate), rcond=None)[0]
    return float(left @ left)


def test_halves_tell_an_asymmetry_from_a_square_better_than_rates_as_long():
    blocks = {one.name: one for one in blocks_of(able(VERTICAL, EAST, INNER))}
    for axis in ("px", "py", "pz"):
        (rates,), (halves,) = (blocks[f"{name}_{axis}"].steps for name in ("rates", "halves"))
        assert len(halves.rates_deg_s) == len(rates.rates_deg_s)
        assert of_magnitude(halves.rates_deg_s) > 2.0 * of_magnitude(rates.rates_deg_s)


def test_both_bisectors_of_each_two_axes_are_turned_about():
    station = able(VERTICAL, EAST, INNER)
    (block,) = (one for one in blocks_of(station) if one.name == "aslant")
    ways = [upward(station, step.angles_deg) for step in block.steps]
    products = {tuple(np.round(np.outer(way, way)[np.triu_indices(3, 1)], 3)) for way in ways}
    assert products == {tuple(0.5 * sign * np.eye(3)[k]) for k in range(3) for sign in (1.0, -1.0)}
    assert {(step.axis, step.up) for step in block.steps} == {(None, None)}
    assert "aslant" not in [one.name for one in blocks_of(able(VERTICAL))]


def test_an_axis_that_does_not_turn_on_and_on_is_not_spun():
    names = [block.name for block in blocks_of(able(VERTICAL, EAST, INNER, endless=False))]
    assert not [
        name for name in names if name.startswith(("swing", "rates", "halves", "turns", "aslant"))
    ]
    assert "tumble" in names


def test_a_chamber_is_heated_and_cooled_within_its_limits_while_the_table_rests():
    warm = ChamberLimits(temperature_degc=(22.0, 35.0), rate_k_min=3.0)
    station = replace(able(VERTICAL, EAST, INNER), chamber=warm)
    assert not [one for one in blocks_of(able(VERTICAL, EAST, INNER)) if "heated" in one.name]
    found = [one for one in blocks_of(station) if "heated" in one.name]
    assert found
    for block in found:
        assert not block.moves
        assert [step.chamber_degc for step in block.steps] == [35.0, 22.0]
    hot = EnvironmentLimits(temperature_degc=(15.0, 25.0), humidity_percent=(20.0, 80.0))
    assert room_of(found[0].steps, hot).temperature_degc == (15.0, 35.0)


# A unit follows the chamber by its own time constant, the chamber goes no faster than it can.

FAST = ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6000.0)
SLOW = ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6.0)
T = np.arange(0.0, 600.0, 0.1)


def recorded(degc: np.ndarray) -> Recording:
    noise = np.random.default_rng(1).normal(scale=0.02, size=len(T))
    return Recording(MANIFEST, Stream(T, {"temperature": degc + noise}))


def test_the_time_constant_is_that_of_the_warm_up():
    found = ThermalResponse.of(recorded(30.0 - 8.0 * np.exp(-T / 200.0)), SLOW)
    assert found is not None
    assert found.lag_s == pytest.approx(200.0, rel=0.1)
    assert found.temperatures(T, []) == pytest.approx(30.0 - 8.0 * np.exp(-T / 200.0), abs=0.2)


def test_a_unit_that_is_warm_tells_none():
    found = ThermalResponse.of(recorded(np.full(len(T), 30.0)), SLOW)
    assert found is not None
    assert found.lag_s == USUAL_LAG


def test_a_unit_without_a_thermometer_is_not_heated():
    bare = replace(recorded(T), imu=Stream(T, {"gyro_x": T}))
    assert ThermalResponse.of(bare, SLOW) is None


def test_the_unit_goes_by_as_much_as_the_air_in_its_time_constant():
    response = ThermalResponse(28.0, 0.0, 100.0, 20.0, FAST)
    series = response.temperatures(T, [(100.0, 30.0)])
    assert series[T < 100.0] == pytest.approx(28.0)
    assert float(series[T >= 200.0][0]) == pytest.approx(28.0 + 10.0 * (1 - np.exp(-1)), abs=0.05)


def test_slow_air_is_followed_late_and_turns_back_from_where_it_got():
    response = ThermalResponse(20.0, 0.0, 1.0, 20.0, SLOW)
    series = response.temperatures(T, [(100.0, 40.0), (160.0, 20.0)])
    assert series.max() == pytest.approx(26.0, abs=0.2)
    assert float(series[-1]) == pytest.approx(20.0, abs=0.01)
