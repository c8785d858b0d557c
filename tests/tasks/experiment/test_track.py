"""A procedure as an ideal table records it: within its limits, at its angles, for its times."""

import numpy as np
import pytest

from schemas.laboratory import ChamberLimits
from schemas.procedure import EnvironmentLimits, Position, Procedure, RateRun, Refix, Turns
from schemas.recording import Mount
from tasks.experiment.track import ThermalResponse, planned_recording
from tests.manifests import THREE_AXES, manifest_of

HZ = 500.0
HERE = {"latitude_deg": 40.0, "gravity_m_s2": 9.8, "heading_deg": 0.0}
MANIFEST = manifest_of("like", HERE, THREE_AXES)
REST = Position(name="rest", item="i", up="+y", angles_deg=(0, 90, 0), dwell_s=2.0)
SPIN = RateRun(
    name="spin", item="i", axis="z", up="+z", spin_axis=0, angles_deg=(0, 0, 0),
    rates_deg_s=(200, -200), dwell_s=1.5,
)  # fmt: skip
ASLANT = RateRun(
    name="aslant", item="i", spin_axis=0, angles_deg=(0, 45, 0), rates_deg_s=(200,), dwell_s=1.5
)
TURNS = Turns(
    name="turns", item="i", axis="z", up="+z", spin_axis=0, angles_deg=(0, 0, 0), turns=2,
    rate_deg_s=90,
)  # fmt: skip


def procedure(*steps: Position | RateRun | Turns | Refix) -> Procedure:
    return Procedure(
        name="p", title="t", title_zh="t", standard="other", warm_up_s=0.0, settle_s=0.1,
        environment=EnvironmentLimits(temperature_degc=(15, 25), humidity_percent=(20, 80)),
        move_rate_deg_s=60, acceleration_deg_s2=100, steps=steps,
    )  # fmt: skip


def angles(*steps: Position | RateRun | Turns) -> tuple[np.ndarray, np.ndarray, tuple[slice, ...]]:
    """Times, angles (n, 3) deg, and the rows of each segment."""
    planned = planned_recording(procedure(*steps), MANIFEST, HZ)
    assert planned.table is not None
    table = planned.table.stack(tuple(f"{axis}_angle" for axis in THREE_AXES))
    rows = tuple(planned.table.rows(s.t_start, s.t_end) for s in planned.manifest.segments or ())
    return planned.table.t, np.degrees(table), rows


def test_nothing_is_faster_or_more_sudden_than_the_procedure_allows():
    _, found, _ = angles(REST, SPIN, TURNS, REST)
    rate = np.diff(found, axis=0) * HZ
    assert np.abs(rate).max() <= 200.0 * (1 + 1e-6)
    assert np.abs(rate[:, 1:]).max() <= 60.0 * (1 + 1e-6)
    assert np.abs(np.diff(rate, axis=0) * HZ).max() <= 100.0 * 1.1


def test_rests_are_at_their_angles_and_rates_at_their_rates_for_their_times():
    t, found, (rest, fast, back) = angles(REST, SPIN)
    assert found[rest] == pytest.approx(np.tile((0.0, 90.0, 0.0), (rest.stop - rest.start, 1)))
    assert t[rest][-1] - t[rest][0] == pytest.approx(2.0, abs=2 / HZ)
    for rows, rate in ((fast, 200.0), (back, -200.0)):
        assert np.diff(found[rows, 0]) * HZ == pytest.approx(rate, rel=1e-6)
        assert t[rows][-1] - t[rows][0] == pytest.approx(1.5, abs=2 / HZ)


def test_a_rate_run_at_other_angles_begins_there_from_rest():
    _, found, (_, back, tilted) = angles(SPIN, ASLANT)
    assert found[back, 1] == pytest.approx(0.0)
    assert found[tilted, 1] == pytest.approx(45.0)
    moving = np.abs(np.diff(found[:, 1])) > 1e-9
    assert np.abs(np.diff(found[:, 0]))[moving] == pytest.approx(0.0, abs=1e-9)


def test_the_label_of_a_unit_held_aslant_names_the_axis_of_the_table():
    planned = planned_recording(procedure(SPIN, ASLANT), MANIFEST, HZ)
    straight, _, tilted = planned.manifest.segments or ()
    assert (straight.axis, straight.table_axis) == ("z", None)
    assert (tilted.axis, tilted.table_axis, tilted.up) == (None, 0, None)


def test_the_thermometer_follows_the_chamber_from_the_step_that_sets_it():
    chamber = ChamberLimits(temperature_degc=(0, 50), rate_k_min=600.0)
    heated = REST.model_copy(update={"name": "hot", "chamber_degc": 40.0, "dwell_s": 20.0})
    planned = planned_recording(
        procedure(REST, heated), MANIFEST, HZ, ThermalResponse(25.0, 0.0, 5.0, 20.0, chamber)
    )
    degc, (_, hot) = planned.imu.columns["temperature"], planned.manifest.segments or ()
    assert degc[planned.imu.t < hot.t_start] == pytest.approx(25.0)
    assert 40.0 < degc[-1] < 45.0
    cold = planned_recording(procedure(REST), MANIFEST, HZ)
    assert "temperature" not in cold.imu.columns


def test_turns_are_whole_ones_forward_and_back_from_rest_to_rest():
    _, found, (forward, back) = angles(TURNS)
    for rows, turned in ((forward, 720.0), (back, -720.0)):
        assert found[rows][-1, 0] - found[rows][0, 0] == pytest.approx(turned, abs=0.01)


def test_a_unit_that_is_turned_over_is_not_planned_for():
    over = Refix(name="over", mount=Mount(), instruction="Turn.", instruction_zh="翻转。")
    with pytest.raises(ValueError, match="turns the unit over"):
        planned_recording(procedure(over, REST), MANIFEST, HZ)
