"""The recording of a run: manifest and streams of `mimu-recording/1`."""

import numpy as np

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tests.proof.plant.case import Case
from tests.proof.plant.noise_free_case import NoiseFree
from tests.proof.plant.plan import Plan
from tests.proof.plant.seeds import generator
from tests.proof.plant.weather import weather

ENCODER_NOISE, ENCODER_STEP = 2e-7, 1e-7  # rad
SPEED_NOISE, SPEED_STEP = 1e-6, 1e-7  # rad/s
SENSOR_NOISE = 0.02  # K, of the unit's own thermometer


def recording_of(case: Case, noise_free: NoiseFree, readings: np.ndarray) -> Recording:
    """Readings (6, n) with the table's and the room's streams and the manifest."""
    channels = dict(zip(GYRO + ACCEL, readings, strict=True))
    rng = generator(case.seed, "thermometer")
    if case.temperature_recorded:
        own = weather(case, noise_free.true_time).temperature
        channels["temperature"] = _rounded(own + SENSOR_NOISE * rng.standard_normal(len(own)), 1e-3)
    return Recording(
        manifest=manifest_of(case, noise_free.plan),
        imu=Stream(noise_free.stamp, channels),
        table=_table(case, noise_free),
        environment=room_stream(case, noise_free.plan),
    )


def manifest_of(case: Case, plan: Plan) -> Manifest:
    """What the bench's program would write: it knows no effect."""
    axes = zip(plan.table.names, plan.table.directions, strict=True)
    segments = [
        {
            "name": planned.name,
            "kind": planned.kind,
            "t_start": start,
            "t_end": end,
            **planned.label,
        }
        for planned, start, end in zip(plan.segments, plan.bounds, plan.bounds[1:], strict=False)
    ]
    if len(set(plan.mounts)) > 1:
        for segment, planned in zip(segments, plan.segments, strict=True):
            segment["mount"] = {"quaternion_wxyz": plan.mounts[planned.fixing]}
    return Manifest.model_validate({
        "format": "mimu-recording/1",
        "recording_id": f"plant_{case.procedure}_{case.seed}",
        "standard": plan.standard,
        "unit": {
            "manufacturer": "Plant", "model": f"M-{case.grade}", "serial": f"SN{case.seed:05d}"
        },
        "station": {
            "id": "PLANT",
            "latitude_deg": case.latitude_deg if case.site_known else None,
            "gravity_m_s2": case.gravity_m_s2,
            "heading_deg": case.heading_deg if case.site_known else None,
            "table_axes": [{"name": name, "direction": where} for name, where in axes],
        },
        "mount": {"quaternion_wxyz": plan.mounts[0]},
        "streams": {name: f"{name}.parquet" for name in ("imu", "table", "environment")},
        "segments": segments,
    })  # fmt: skip


def _table(case: Case, noise_free: NoiseFree) -> Stream:
    rng = generator(case.seed, "encoder")
    columns = {}
    streams = zip(
        noise_free.plan.table.names, noise_free.table_angles, noise_free.table_rates, strict=True
    )
    for name, angle, rate in streams:
        jitter = ENCODER_NOISE * rng.standard_normal(len(angle))
        columns[f"{name}_angle"] = _rounded(angle + jitter, ENCODER_STEP)
        jitter = SPEED_NOISE * rng.standard_normal(len(rate))
        columns[f"{name}_rate"] = _rounded(rate + jitter, SPEED_STEP)
    return Stream(noise_free.table_t, columns)


def room_stream(case: Case, plan: Plan) -> Stream:
    """Air temperature, humidity, supply and pressure, once a second."""
    t = np.arange(0.0, np.floor(plan.duration))
    room = weather(case, t)
    return Stream(t, {
        "temperature": _rounded(room.air, 0.01),
        "humidity": _rounded(room.humidity, 0.01),
        "supply_voltage": _rounded(room.supply, 1e-4),
        "pressure": _rounded(room.pressure, 0.01),
    })  # fmt: skip


def _rounded(values: np.ndarray, step: float) -> np.ndarray:
    return np.asarray(np.round(values / step) * step)
