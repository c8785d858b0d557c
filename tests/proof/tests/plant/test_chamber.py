"""A chamber that a procedure sets warms the unit, late, and nothing else changes."""

import numpy as np
import pytest

from schemas.procedure import EnvironmentLimits, Position, Procedure
from tests.proof.plant.case import Case
from tests.proof.plant.world import weather

T = np.arange(0.0, 900.0, 1.0)


def case(*set_to: float | None) -> Case:
    steps = tuple(
        Position(name=f"rest_{k}", item="i", up="+z", angles_deg=(0, 0, 0), dwell_s=300.0,
                 chamber_degc=degc)
        for k, degc in enumerate(set_to)
    )  # fmt: skip
    procedure = Procedure(
        name="p", title="t", title_zh="t", standard="other", warm_up_s=0.0, settle_s=0.1,
        environment=EnvironmentLimits(temperature_degc=(0, 50), humidity_percent=(20, 80)),
        move_rate_deg_s=60, acceleration_deg_s2=100, steps=steps,
    )  # fmt: skip
    return Case(seed=5, procedure="given", given=procedure.model_dump(mode="json"))


def test_the_air_goes_where_it_is_set_and_the_unit_follows() -> None:
    plain, heated = weather(case(None, None, None), T), weather(case(None, 40.0, None), T)
    air, unit = heated.air - plain.air, heated.temperature - plain.temperature
    assert np.abs(air[T < 300.0]).max() == 0.0
    assert 15.0 < air[-1] < 25.0
    assert 0.0 < unit[T == 500.0][0] < air[T == 500.0][0]
    assert (heated.supply == plain.supply).all()


def test_the_change_of_the_temperature_is_that_of_the_temperature() -> None:
    found = weather(case(40.0, None, 20.0), T)
    assert np.gradient(found.temperature, T)[5:-5] == pytest.approx(
        found.temperature_rate[5:-5], abs=2e-3
    )
