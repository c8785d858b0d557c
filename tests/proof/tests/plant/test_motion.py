"""The run's kinematics against rotations and rates written by another hand (scipy, formulas)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.procedure import EnvironmentLimits, Position, Procedure
from tests.proof.plant.case import Case, about, product, turned, vector_of
from tests.proof.plant.world import weather
from tests.proof.tests.plant.short_case import case_of, noise_free


def test_rates_and_force_are_those_of_the_reported_angles() -> None:
    run = noise_free(case_of(fields={"heading_deg": 30.0}))
    outer, middle, _ = run.table_angles
    base = Rotation.from_euler("z", -np.radians(30.0))
    first = base * Rotation.from_euler("z", outer[:, None])
    second = first * Rotation.from_euler("x", middle[:, None])
    unit = second * Rotation.from_euler("z", run.table_angles[2][:, None])
    spun = (
        np.outer(run.table_rates[0], [0, 0, 1])
        + run.table_rates[1][:, None] * first.apply([1, 0, 0])
        + run.table_rates[2][:, None] * second.apply([0, 0, 1])
    )
    assert np.abs(unit.apply(spun, inverse=True).T - run.reported[:3]).max() < 2e-5
    force = unit.apply([0, 0, 9.8015], inverse=True).T
    assert np.abs(force - run.reported[3:]).max() < 1e-8


def test_positions_bring_the_named_axis_up() -> None:
    for procedure in ("three_axis", "single_axis"):
        run = noise_free(case_of(fields={"procedure": procedure}))
        for segment, low, high in zip(
            run.plan.segments, run.plan.bounds, run.plan.bounds[1:], strict=False
        ):
            if segment.kind == "static":
                row = int((low + high) / 2 * 100)
                up = np.zeros(3)
                up["xyz".index(segment.label["up"][1])] = (
                    1.0 if segment.label["up"][0] == "+" else -1.0
                )
                assert run.reported[3:, row] == pytest.approx(9.8015 * up, abs=1e-4), segment.name


@pytest.mark.parametrize("procedure", ["three_axis", "single_axis", "six_orientations", "ahrs"])
def test_the_named_axis_turns_at_the_labelled_rate(procedure: str) -> None:
    run = noise_free(case_of(fields={"procedure": procedure}))
    turning = [n for n, segment in enumerate(run.plan.segments) if segment.kind == "rate"]
    assert turning
    for number in turning:
        segment, row = (
            run.plan.segments[number],
            int(run.plan.bounds[number : number + 2].mean() * 100),
        )
        rates = np.zeros(3)
        rates["xyz".index(segment.label["axis"])] = np.radians(segment.label["rate_deg_s"])
        assert run.reported[:3, row] == pytest.approx(rates, abs=2e-4), segment.name


def test_whole_turns_of_the_ahrs_run_are_whole() -> None:
    run = noise_free(case_of(fields={"procedure": "ahrs"}))
    turns = [n for n, segment in enumerate(run.plan.segments) if segment.kind == "rotation"]
    assert len(turns) == 6
    for number in turns:
        rows = (run.plan.bounds[number : number + 2] * 100).astype(int)
        turned_by = np.diff(run.table_angles[0][rows])[0]
        label = np.radians(run.plan.segments[number].label["angle_deg"])
        assert turned_by == pytest.approx(label, abs=1e-5)


def test_rotations_compose_as_scipy_composes_them() -> None:
    rng = np.random.default_rng(1)
    axis = np.array([0.6, 0.0, 0.8])
    angles, vector = rng.uniform(-3, 3, 50), rng.standard_normal((3, 50))
    ours = product(about(axis, angles), about(np.array([1.0, 0, 0]), 0.3))
    theirs = Rotation.from_rotvec(np.outer(angles, axis)) * Rotation.from_euler("x", 0.3)
    assert np.allclose(turned(ours, vector).T, theirs.apply(vector.T))
    small = about(axis, 1e-3 * angles)
    assert np.allclose(vector_of(small), 1e-3 * np.outer(axis, angles), atol=1e-15)


# A chamber that a procedure sets warms the unit, late, and nothing else changes.

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
