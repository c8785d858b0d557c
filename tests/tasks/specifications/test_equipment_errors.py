"""What budgets say that the equipment does, against runs in which it does, and closed formulas."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.laboratory import EquipmentLimit
from schemas.recording import Recording
from tasks.calibrate.calibrate import Evaluation, evaluation_for
from tasks.motion.table import EARTH_RATE
from tasks.specifications.equipment_errors import axes_of_table
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003 as JJF2003_CLAUSES
from tasks.specifications.joint import JOINT
from tasks.uncertainty.equipment import JJF2003, Equipment, ErrorLimit
from tasks.validation import run2003
from tasks.validation.coverage import simulate
from tasks.validation.simulated_units import SimulatedUnit, draw_simulated_unit
from tests.manifests import at_station
from tests.tasks.items_only import items_only

LIMITS = {
    limit.symbol: limit
    for limit in (
        JJF2003.rates[0][1],
        JJF2003.gravity,
        JJF2003.latitude,
        JJF2003.fixture,
        JJF2003.axes,
        JJF2003.level,
    )
    if limit is not None
}
SIZES = {"ε1": 1e-4, "g": 1e-2, "φ": 1e-3, "α4": 1e-4, "α3": 1e-4, "α5": 1e-4}  # in the units
DRAWS = {"α4": 3, "α3": 2, "α5": 2}  # of what is drawn more than once in a run
PLACE_M = 0.005  # of the accelerometers from the axes, at most
METHODS = {each.method: each for each in (JJF2003_CLAUSES, JOINT)}


@dataclass(frozen=True)
class Planted(SimulatedUnit):
    """A unit with noise on equipment without errors but one: the noise is the same each time."""

    symbol: str = ""
    axis: int = 0

    def error(self, *limits: ErrorLimit | None) -> float:
        wrong = [limit for limit in limits if limit is not None and limit.symbol == self.symbol]
        return SIZES[self.symbol] if wrong and len(limits) == 1 else 0.0

    def errors(self, count: int, *limits: ErrorLimit | None) -> np.ndarray:
        return self.error(*limits) * np.eye(count)[min(self.axis, count - 1)]


def calibrated(method: str, symbol: str = "", axis: int = 0) -> Calibration:
    simulated = draw_simulated_unit(4, run2003.RATE_HZ)
    recording, _ = run2003.record(Planted(simulated.unit, simulated.random, False, symbol, axis))
    return items_only(METHODS[method], thinned(recording))


def thinned(recording: Recording) -> Recording:
    """Every third row, which tells as much of an error that is the same in all of them."""
    kept = slice(None, None, 3)
    table = recording.table and recording.table.at(kept)
    return replace(recording, imu=recording.imu.at(kept), table=table)


@pytest.fixture(scope="module", params=METHODS)
def right(request) -> Calibration:
    return calibrated(request.param)


@pytest.mark.parametrize("symbol", SIZES)
def test_each_value_moves_by_the_error_times_its_sensitivity(right, symbol):
    """To a hundredth of it, or of what all standard uncertainties together do.

    A fixture wrong about each axis: the lines hold the root of the sum of three squares.
    """
    moved = [calibrated(right.method, symbol, axis) for axis in range(DRAWS.get(symbol, 1))]
    compared = 0
    for name, item in right.items.items():
        for element, budget in item.budgets.items():
            changes = [each.items[name].value[element] - budget.value for each in moved]
            lines = [line for line in budget.inputs if line.symbol == symbol]
            expected = sum(abs(line.sensitivity) for line in lines) * SIZES[symbol]
            left = 0.01 * budget.u_c * SIZES[symbol] / LIMITS[symbol].u
            if name == "accel_rate_sensitivity":
                left += PLACE_M * SIZES[symbol]  # a tilted axis passes the sensors elsewhere
            assert np.linalg.norm(changes) == pytest.approx(expected, rel=0.01, abs=left), (
                f"{name}.{element}"
            )
            compared += expected > left
    assert compared >= {"ε1": 3, "g": 3, "φ": 0, "α4": 12, "α3": 6, "α5": 3}[symbol], compared


def test_what_is_left_of_earth_s_rotation_follows_the_latitude(right):
    """The clause's own value holds Earth's rotation, whatever the latitude is said to be."""
    item = right.items["gyro_g_sensitivity"]
    without = item.u_without_earth_rotation
    assert without is not None
    more = np.degrees(EARTH_RATE * np.cos(np.radians(39.9)) * JJF2003.latitude.u)
    symbols = [line.symbol for line in item.budgets["xx"].inputs]
    if right.method == "joint":
        assert "φ" in symbols
    else:
        assert "φ" not in symbols
        assert without["xx"] ** 2 - item.u["xx"] ** 2 == pytest.approx(more**2, rel=0.05)


# The weights of settings, of faces (one axis up) and of the mounting in eq. (8) and (11). The bias
# of an accelerometer that lies level in four of six faces reads a tilt there; a coupling has it up
# less down, and the one mounting whole.
LEVEL = {"position": np.full(8, 1 / 12), "axes": np.full(4, 1 / 6), "fixture": np.zeros(3)}
UP_LESS_DOWN = {"position": np.full(4, 1 / 4), "axes": np.full(2, 1 / 2), "fixture": np.ones(1)}


@pytest.mark.parametrize("limit", LEVEL)
def test_without_encoders_faces_and_settings_tilt_as_the_closed_formulas_say(limit):
    """Twelve positions by labels alone: each setting, each face or the mounting is off anyhow."""
    simulated = draw_simulated_unit(4, run2003.RATE_HZ, ideal=True)
    recording = thinned(run2003.record(simulated)[0])
    error = getattr(JJF2003, limit)
    own = Equipment(**{"axes": JJF2003.axes, limit: error})
    labelled = replace(at_station(recording, table_axes=None), table=None)
    made = items_only(JJF2003_CLAUSES, labelled, Evaluation(own))
    g = recording.manifest.station.gravity_m_s2
    scale = made.items["accel_scale_factor"].value
    for item, weights, per_radian in (
        ("accel_cross_coupling", UP_LESS_DOWN, 1.0), ("accel_bias", LEVEL, g)
    ):  # fmt: skip
        for element, value in made.items[item].value.items():
            assert value is not None
            expected = per_radian * scale[element[0]] * np.linalg.norm(weights[limit]) * error.u
            found = contribution(made, item, element, error.symbol)
            assert found == pytest.approx(expected, rel=0.01, abs=1e-9)


def contribution(made: Calibration, item: str, element: str, symbol: str) -> float:
    lines = made.items[item].budgets[element].inputs
    return sum(line.contribution for line in lines if line.symbol == symbol)


def test_the_covariance_has_the_budgets_on_its_diagonal_and_one_rate_in_every_scale(right):
    assert right.covariance is not None
    elements, rows = right.covariance.elements, right.covariance.rows
    u = {f"{key}.{e}": each for key, item in right.items.items() for e, each in item.u.items()}
    for name, row in zip(elements, rows, strict=True):
        assert row[-1] ** 0.5 == pytest.approx(u[name], rel=1e-6), name
    x, y = (elements.index(f"gyro_scale_factor.{axis}") for axis in "xy")
    correlation = rows[y][x] / (rows[x][-1] * rows[y][-1]) ** 0.5
    rate = contribution(right, "gyro_scale_factor", "x", "ε1")
    assert correlation == pytest.approx((rate / u["gyro_scale_factor.x"]) ** 2, abs=0.05)
    full = np.zeros((len(rows), len(rows)))
    for p, row in enumerate(rows):
        full[p, : p + 1] = full[: p + 1, p] = row
    size = np.sqrt(np.diag(full))
    assert np.linalg.eigvalsh(full / np.outer(size, size))[0] > -1e-9


FAST = 1e-4  # by so much the clock of the recording runs fast


def by_another_clock(recording: Recording) -> Recording:
    """The same with all its times longer."""
    labels = tuple(
        label.model_copy(
            update={"t_start": label.t_start * (1 + FAST), "t_end": label.t_end * (1 + FAST)}
        )
        for label in recording.manifest.segments or ()
    )
    manifest = recording.manifest.model_copy(update={"segments": labels})
    imu, table = (
        stream and replace(stream, t=stream.t * (1 + FAST))
        for stream in (recording.imu, recording.table)
    )
    return replace(recording, manifest=manifest, imu=imu, table=table)


@pytest.mark.parametrize("method", [JJF2003_CLAUSES, JOINT, JJF1536], ids=lambda m: m.method)
def test_a_clock_that_runs_fast_is_inside_of_a_time_base_that_is_stated(method):
    """And blocks every pass, where encoders show rates that the table was not set to."""
    recording = simulate(method.method, 4, ideal=True)[0]
    recording = recording if method is JJF1536 else thinned(recording)
    stated = EquipmentLimit(half_width=FAST, distribution="rectangular", source="c")
    own = evaluation_for(recording, own={"time_base": stated})
    right = items_only(method, recording, own)
    wrong = items_only(method, by_another_clock(recording), own)
    scale = "ahrs_scale_factor" if method is JJF1536 else "gyro_scale_factor"
    for element, value in right.items[scale].value.items():
        change = wrong.items[scale].value[element] - value
        (line,) = (
            line for line in right.items[scale].budgets[element].inputs if line.symbol == "ε4"
        )
        assert abs(change) == pytest.approx(abs(line.sensitivity) * FAST, rel=0.01)
    codes = {each.code for each in wrong.remarks if each.blocks_pass}
    assert ("time_base" in codes) == (method is not JJF1536)
    assert "time_base" not in {each.code for each in right.remarks}


def without_encoders(recording: Recording) -> Recording:
    return replace(recording, table=None)


def test_labels_of_a_table_that_is_described_stand_for_its_encoders():
    """The same angles, and the same u of what tilts change."""
    recording = thinned(simulate("jjf2003", 4, ideal=True)[0])
    seen, labelled = (
        axes_of_table(JJF2003_CLAUSES.gather(r)) for r in (recording, without_encoders(recording))
    )
    assert seen is not None
    assert labelled is not None
    inner = np.degrees(labelled.angles[:, 1:] - seen.angles[:, 1:])
    assert np.abs((inner + 180.0) % 360.0 - 180.0).max() < 1e-6
    made = [items_only(JJF2003_CLAUSES, r) for r in (recording, without_encoders(recording))]
    for name in ("gyro_cross_coupling", "accel_cross_coupling", "accel_scale_factor", "accel_bias"):
        for element, u in made[0].items[name].u.items():
            assert made[1].items[name].u[element] == pytest.approx(u, rel=0.05), f"{name}.{element}"


def test_a_rate_about_an_axis_that_nobody_calls_vertical_has_its_errors_too():
    """Gyros alone, and labels that name no axis up."""
    recording = thinned(simulate("jjf2003", 4, ideal=True)[0])
    gyros = {n: v for n, v in recording.imu.columns.items() if n.startswith("gyro")}
    labels = tuple(
        label.model_copy(update={"up": None}) if label.kind == "rate" else label
        for label in recording.manifest.segments or ()
    )
    blind = replace(
        recording,
        table=None,
        imu=replace(recording.imu, columns=gyros),
        manifest=recording.manifest.model_copy(
            update={
                "segments": labels,
                "table_time": {
                    "commanded_rate": {"half_width": 1e-5, "distribution": "rectangular"}
                },
            }
        ),
    )
    right, made = items_only(JJF2003_CLAUSES, recording), items_only(JJF2003_CLAUSES, blind)
    for name, symbol in (("gyro_scale_factor", "ε1"), ("gyro_cross_coupling", "α4")):
        for element in right.items[name].value:
            expected = contribution(right, name, element, symbol)
            by_label = {"ε1": "ε5"}.get(symbol, symbol)
            assert contribution(made, name, element, by_label) == pytest.approx(expected, rel=0.01)
