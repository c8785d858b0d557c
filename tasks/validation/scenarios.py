"""The conditions of laboratories other than the validation's own, as changes to its recordings.

A scenario is the conditions that it has beside those of a run in which everything is in order, the
changes that make them, and what a laboratory states of it. A result's own conditions are read off
what it says of itself; it lies in a scenario that has all of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from schemas.calibration import Calibration, Method, ScenarioValidation
from schemas.laboratory import EquipmentLimit, LimitName
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.calibrate.calibrate import evaluation_for
from tasks.validation.coverage import (
    Calibrate,
    Errors,
    Truth,
    errors_of,
    in_processes,
    simulate,
    summarise,
)
from tasks.validation.record import G_SENSITIVITY, WITHOUT_EARTH

Made = tuple[Recording, Truth]
Change = Callable[[Recording, Truth, np.random.Generator], Made]

MOUNT_DEG = 1.0
RATE_OFF = 2e-4  # relative, of rates that labels alone state
POLLED_S, POLLS_HZ = 2e-3, 10.0  # within which a polled angle's time is known, and how often
LONGEST_S, FLICKER = 3e4, np.array([4e-6] * 3 + [6e-5] * 3)  # s; √h in rad/s, m/s²
WARM_K, WARM_S, AIR_DEGC = 3.0, 600.0, 25.0
PER_KELVIN = "per kelvin"  # beside the items of a truth: by scale factor and axis, 1/K
SCALE_FACTORS = ("gyro_scale_factor", "accel_scale_factor")
OF_TEMPERATURE = np.array([2e-4] * 3 + [1e-4] * 3)  # 1/K, of the scale factors
DRIFT = np.array([1e-4] * 3 + [2e-3] * 3)  # rad/s, m/s²: 5 % of a bias's range
COARSE = (0.05, 0.5)  # noise of a row over the step


@dataclass(frozen=True)
class Scenario:
    """methods: that it is for. own: the limits that a laboratory states."""

    conditions: frozenset[str]
    methods: tuple[Method, ...]
    changes: tuple[Change, ...]
    own: Mapping[LimitName, EquipmentLimit] = field(default_factory=dict)

    def make(self, method: str, seed: int) -> Made:
        """The recording of a unit with this seed, and the truth of its items."""
        recording, truth = simulate(method, seed)
        random = np.random.default_rng((seed, 56))
        for change in self.changes:
            recording, truth = change(recording, truth, random)
        return recording, truth


def study_scenarios(
    methods: Mapping[str, Calibrate], units: int, seed: int, report: Callable[[int, int], None]
) -> dict[str, ScenarioValidation]:
    """Coverage of every item in each scenario over as many units, in a process for each core."""
    jobs = [
        (name, method, methods[method], seed + i)
        for name, scenario in SCENARIOS.items()
        for method in scenario.methods
        for i in range(units)
    ]
    errors: dict[str, dict[Method, list[Errors]]] = {name: {} for name in SCENARIOS}
    invalid = dict.fromkeys(SCENARIOS, 0)
    for done, (name, method, found, is_invalid) in enumerate(in_processes(_errors_in, jobs), 1):
        errors[name].setdefault(method, []).append(found)
        invalid[name] += is_invalid
        report(done, len(jobs))
    return {
        name: ScenarioValidation(
            conditions=tuple(sorted(scenario.conditions)), units=units, invalid=invalid[name],
            items={method: summarise(found) for method, found in errors[name].items()},
        )
        for name, scenario in SCENARIOS.items()
    }  # fmt: skip


def _errors_in(job: tuple[str, Method, Calibrate, int]) -> tuple[str, Method, Errors, bool]:
    """One unit in a scenario, and whether its run was called invalid; for a process of its own."""
    name, method, calibrate, seed = job
    recording, truth = SCENARIOS[name].make(method, seed)
    evaluation = evaluation_for(recording, own=SCENARIOS[name].own)
    made = calibrate(recording, run="simulated", code_version="-", evaluation=evaluation)
    invalid = any(one.run == "invalid" for one in made.remarks)
    return name, method, errors_of(made, _where_it_holds(made, truth)), invalid


def _where_it_holds(made: Calibration, truth: Truth) -> Truth:
    """The truth at the temperature at which each element is said to hold."""
    slopes, moved = truth.get(PER_KELVIN, {}), dict(truth)
    for name in SCALE_FACTORS if slopes else ():
        at = made.items[name].temperature_degc or {}
        moved[name] = {
            e: true * (1.0 + slopes[name + e] * ((at.get(e) or slopes["mean"]) - slopes["mean"]))
            for e, true in truth[name].items()
        }
    return moved


def _stated(recording: Recording, **fields: object) -> Recording:
    manifest = recording.manifest
    made = type(manifest).model_validate(manifest.model_dump() | fields)
    return replace(recording, manifest=made)


def _read(recording: Recording, values: np.ndarray, **more: np.ndarray) -> Recording:
    """The recording with other readings (n, 6) of its unit."""
    columns = dict(zip(GYRO + ACCEL, values.T, strict=True)) | more
    return replace(recording, imu=replace(recording.imu, columns=columns))


def by_labels(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """No encoders: the labels are off by one error, whose limit the manifest states."""
    off = 1.0 + random.uniform(-RATE_OFF, RATE_OFF)
    labels = [
        label.model_copy(update={"rate_deg_s": label.rate_deg_s and label.rate_deg_s / off})
        for label in recording.manifest.segments or ()
    ]
    bound = {"half_width": RATE_OFF, "distribution": "rectangular"}
    held = _stated(recording, table_time={"commanded_rate": bound})
    segments = [label.model_dump(exclude_none=True) for label in labels]
    return replace(_stated(held, segments=segments), table=None), truth


def mounted_askew(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """The unit's axes are turned in the fixture, as the manifest states; p is not of its axes."""
    from scipy.spatial.transform import Rotation  # late: it takes a third of a start

    direction = random.standard_normal(3)
    turn = Rotation.from_rotvec(np.radians(MOUNT_DEG) * direction / np.linalg.norm(direction))
    made = {name: dict(elements) for name, elements in truth.items()}
    made.pop("accel_rate_sensitivity", None)
    for own, across in (
        ("gyro_scale_factor", "gyro_cross_coupling"),
        ("accel_scale_factor", "accel_cross_coupling"),
        (G_SENSITIVITY, G_SENSITIVITY), (WITHOUT_EARTH, WITHOUT_EARTH),
    ):  # fmt: skip
        if own not in truth:
            continue
        matrix = np.array([
            [truth[own][a if own != across else a + b] if a == b else truth[across][a + b]
             for b in "xyz"] for a in "xyz"
        ]) @ turn.as_matrix()  # fmt: skip
        for i, j in np.ndindex(3, 3):
            name = own if i == j else across
            made[name]["xyz"[i] + ("xyz"[j] if own == across or i != j else "")] = matrix[i, j]
    quaternion = turn.as_quat(scalar_first=True).tolist()
    return _stated(recording, mount={"quaternion_wxyz": quaternion}), made


def by_polls(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """Encoders read ten times a second, each at a time known as well as the manifest states."""
    assert recording.table is not None
    t = np.arange(recording.table.t[0], recording.table.t[-1], 1.0 / POLLS_HZ)
    read = t + random.uniform(-POLLED_S, POLLED_S, len(t))
    angles = {
        name: np.interp(read, recording.table.t, values)
        for name, values in recording.table.columns.items()
    }
    held = _stated(recording, table_time={"half_width_s": POLLED_S})
    return replace(held, table=Stream(t, angles)), truth


def at_one_heading(recording: Recording, truth: Truth, _: np.random.Generator) -> Made:
    """Six positions."""
    kept = [s for s in recording.manifest.segments or () if s.turn_deg != 180.0]
    return _stated(recording, segments=[s.model_dump(exclude_none=True) for s in kept]), truth


def at_two_rates(recording: Recording, truth: Truth, _: np.random.Generator) -> Made:
    """Each axis at ±10 °/s alone, over less than a turn."""
    kept = [s for s in recording.manifest.segments or () if abs(s.rate_deg_s or 10.0) == 10.0]
    short = [s.model_copy(update={"t_end": s.t_start + 9.0}) if s.rate_deg_s else s for s in kept]
    return _stated(recording, segments=[s.model_dump(exclude_none=True) for s in short]), truth


def with_slow_noise(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """1/f beyond the longest relaxation that the model of the noise has."""
    t = recording.imu.t
    rate = (len(t) - 1) / (t[-1] - t[0])
    whole = 2 ** int(np.ceil(np.log2(max(len(t), 4.0 * LONGEST_S * rate))))
    f = np.fft.rfftfreq(whole, 1.0 / rate)
    corner = 1.0 / (2.0 * np.pi * LONGEST_S)
    density = np.divide(np.arctan(f / corner), f, out=np.full(len(f), 1.0 / corner), where=f > 0)
    size = np.sqrt(2.0 / np.pi * density * whole * rate / 4.0)
    parts = random.standard_normal((2, 6, len(f)))
    slow = np.fft.irfft(size * (parts[0] + 1j * parts[1]), whole, axis=1)[:, : len(t)]
    return _read(recording, recording.imu.stack(GYRO + ACCEL) + (FLICKER[:, None] * slow).T), truth


def warming(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """The unit warms, its scale factors with it, and its temperature is recorded."""
    t = recording.imu.t
    warm = WARM_K * (1.0 - np.exp(-t / WARM_S))
    slopes = OF_TEMPERATURE * random.choice([-1.0, 1.0], 6)
    values = recording.imu.stack(GYRO + ACCEL) * (1.0 + np.outer(warm - warm.mean(), slopes))
    names = (name + axis for name in SCALE_FACTORS for axis in "xyz")
    per_kelvin = dict(zip(names, slopes.tolist(), strict=True), mean=AIR_DEGC + float(warm.mean()))
    return _read(recording, values, temperature=AIR_DEGC + warm), truth | {PER_KELVIN: per_kelvin}


def drifting(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """Zeros settle after switching on; the truth is their mean over the run."""
    t = recording.imu.t
    course = 1.0 - np.exp(-t / WARM_S)
    course -= course.mean()
    drift = np.outer(course, DRIFT * random.choice([-1.0, 1.0], 6))
    return _read(recording, recording.imu.stack(GYRO + ACCEL) + drift), truth


def coarsely(recording: Recording, truth: Truth, random: np.random.Generator) -> Made:
    """Readings in steps that hide their noise."""
    values = recording.imu.stack(GYRO + ACCEL)
    label = next(s for s in recording.manifest.segments or () if s.kind == "static")
    noise = values[recording.imu.rows(label.t_start, label.t_end)].std(axis=0)
    step = noise / np.exp(random.uniform(*np.log(COARSE)))
    return _read(recording, np.rint(values / step) * step), truth


MIMU: tuple[Method, ...] = ("jjf2003", "joint")
SCENARIOS: dict[str, Scenario] = {
    "in-order": Scenario(frozenset(), (*MIMU, "jjf1536"), ()),
    "mount": Scenario(frozenset({"mount"}), MIMU, (mounted_askew,)),
    "labels": Scenario(frozenset({"labels"}), MIMU, (by_labels,)),
    "labels-mount": Scenario(frozenset({"labels", "mount"}), MIMU, (mounted_askew, by_labels)),
    "polled": Scenario(frozenset({"polled"}), MIMU, (by_polls,)),
    "one-heading": Scenario(frozenset({"one-heading"}), MIMU, (at_one_heading,)),
    "few-rates": Scenario(frozenset({"few-rates"}), MIMU, (at_two_rates,)),
    "flicker": Scenario(frozenset(), MIMU, (with_slow_noise,)),
    "warming": Scenario(frozenset({"warming"}), MIMU, (warming,)),
    "drift": Scenario(frozenset({"drift"}), MIMU, (drifting,)),
    "coarse-steps": Scenario(frozenset({"coarse-steps"}), MIMU, (coarsely,)),
}
