"""What a run of the line gives: by the plant and the real calibration, or of the same physics."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Manifest, Recording
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import specification_for
from tests.proof.line.draw import Line, LineUnit, Tilt
from tests.proof.plant.case import Case, EffectCall, Grade, UnitErrors, channel_noise, draw_unit
from tests.proof.plant.simulate import simulate

G = 9.80665  # m/s²
AXES = "xyz"
TRUTH_OF_CASE = 1  # of the unit that the plant plays, before it becomes one of the line
Values = dict[str, dict[str, float]]  # by item and element


@dataclass(frozen=True)
class Measured:
    """How units of a grade are measured. template: the real calibration of one recording, whose
    U, units and clauses hold for all. shift: by what the tilt moves each element.
    """

    template: Calibration
    shift: Values


def case_of(seed: int, grade: Grade, tilt: Tilt | None) -> Case:
    """A run of the line as the plant plays it: thirty rests and turns of five seconds."""
    effects = [
        EffectCall(name="axis_tilt", parameters={"east": each.east, "north": each.north})
        for each in [tilt]
        if each is not None
    ]
    return Case(
        seed=seed, unit_seed=TRUTH_OF_CASE, grade=grade, rate_hz=20, rates_deg_s=(30.0, 120.0),
        dwell_s=5.0, effects=tuple(effects),
    )  # fmt: skip


def played(case: Case, truth: UnitErrors, manifest: Manifest | None = None) -> Recording:
    """A case with a unit of these coefficients in the place of the plant's own."""
    simulated = simulate(case)
    rates, force = np.split(simulated.reported.T, 2)
    own = truth.reads(rates, force) - draw_unit(TRUTH_OF_CASE).reads(rates, force)
    steps = [noise.step for noise in channel_noise(case.grade)]
    recording, rng = simulated.recording, np.random.default_rng([case.seed, 63])
    columns = dict(recording.imu.columns)
    for channel, series, step in zip(GYRO + ACCEL, own, steps, strict=True):
        spread = step * (rng.uniform(size=len(series)) - 0.5)  # rounded twice as if once
        columns[channel] = np.round((columns[channel] + spread + series) / step) * step
    imu = replace(recording.imu, columns=columns)
    return replace(recording, imu=imu, manifest=manifest or recording.manifest)


def measured_by_grade(line: Line) -> Mapping[Grade, Measured]:
    """For each grade a recording as it is, and the same one on the tilted station."""
    return {grade: _measured(line, grade) for grade in {unit.grade for unit in line.units}}


def _measured(line: Line, grade: Grade) -> Measured:
    level, tilted = (
        _calibrated(simulate(case_of(line.seed, grade, tilt)).recording)
        for tilt in (None, line.tilt)
    )
    return Measured(level, {
        name: {e: _value(tilted, name, e) - _value(level, name, e) for e in elements}
        for name, elements in true_values(draw_unit(TRUTH_OF_CASE)).items()
    })  # fmt: skip


def _value(calibration: Calibration, item: str, element: str) -> float:
    value = calibration.items[item].value[element]
    assert value is not None
    return value


def _calibrated(recording: Recording) -> Calibration:
    specification = specification_for(recording.manifest.standard, None)
    evaluation = evaluation_for(recording, "GUM", {})
    return calibrate(
        specification, recording, run="r0", code_version="1", evaluation=evaluation,
        own_latitude_deg=None,
    )  # fmt: skip


def true_values(unit: UnitErrors) -> Values:
    """The coefficients as the items of JJF 2003-2022, in their units; SI: models (1) and (2)."""
    pairs = [(i, j) for i in range(3) for j in range(3)]
    beside = [(i, j) for i, j in pairs if i != j]
    degrees = 180.0 / np.pi

    def diagonal(matrix: np.ndarray, factor: float = 1.0) -> dict[str, float]:
        return {AXES[i]: float(matrix[i, i] * factor) for i in range(3)}

    def vector(values: np.ndarray, factor: float = 1.0) -> dict[str, float]:
        return {AXES[i]: float(values[i] * factor) for i in range(3)}

    def of(matrix: np.ndarray, where: list[tuple[int, int]], factor: float) -> dict[str, float]:
        return {AXES[i] + AXES[j]: float(matrix[i, j] * factor) for i, j in where}

    return {
        "gyro_scale_factor": diagonal(unit.Kg),
        "gyro_cross_coupling": of(unit.Kg, beside, 1.0),
        "gyro_bias": vector(unit.Bg, degrees),
        "gyro_g_sensitivity": of(unit.G, pairs, degrees * G),
        "accel_scale_factor": diagonal(unit.Ka),
        "accel_cross_coupling": of(unit.Ka, beside, 1.0),
        "accel_bias": vector(unit.Ba),
        "accel_rate_sensitivity": of(unit.P, beside, -1.0),  # eq. (12): of the other sign
    }


def result_of(
    unit: LineUnit,
    truth: UnitErrors,
    how: Measured,
    tilted: bool,
    rng: np.random.Generator,
    without: str | None,
) -> Calibration:
    """A calibration as the template's with values of this unit: truth, shift and noise of u.

    without: an item that the run does not determine.
    """
    items = {}
    for name, values in true_values(truth).items():
        item = how.template.items[name]
        value: dict[str, float | None] = {
            element: true
            + tilted * how.shift[name][element]
            + float(rng.standard_normal()) * (item.u[element] or 0.0)
            for element, true in values.items()
        }
        if name == without:
            value = dict.fromkeys(values)
        items[name] = item.model_copy(update={
            "value": value, "u": item.u if name != without else value,
            "U": item.U if name != without else value, "budgets": {}, "value_model": None,
            "value_without_earth_rotation": None, "u_without_earth_rotation": None,
            "U_without_earth_rotation": None,
        })  # fmt: skip
    return how.template.model_copy(update={
        "items": items, "information": {}, "segments": (), "remarks": (),
        "unavailable": {without: "no rest of the run is long enough"} if without else {},
        "unavailable_zh": {without: "测量中没有足够长的静止段"} if without else {},
    })  # fmt: skip
