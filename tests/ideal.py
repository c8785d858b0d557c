"""An ideal run of JJF 2003 by plain algebra."""

from typing import Any

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tests.manifests import manifest_of

GRAVITY = 9.78
AXES = "xyz"
RATES = (-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0)


def unit_errors(**changes: Any) -> dict[str, np.ndarray]:
    """An ideal unit's K, B, G, Ka, Ba, P, with the named ones replaced."""
    ideal = {
        "Kg": np.eye(3), "Bg": np.zeros(3), "G": np.zeros((3, 3)),
        "Ka": np.eye(3), "Ba": np.zeros(3), "P": np.zeros((3, 3)),
    }  # fmt: skip
    return ideal | changes


def _stretch(rate: np.ndarray, force: np.ndarray, unit: dict[str, np.ndarray]) -> np.ndarray:
    """Six constant readings of models (1) and (2), written out row by row."""
    gyro = unit["Kg"] @ rate + unit["Bg"] + unit["G"] @ force
    accel = unit["Ka"] @ force + unit["Ba"] + unit["P"] @ rate**2
    return np.concatenate([gyro, accel])


def ideal_run(
    dwell: float = 30.0, noise: float = 1e-9, gravity: float = GRAVITY, **changes: Any
) -> Recording:
    """A JJF 2003 run of a unit whose readings follow models (1) and (2) exactly.

    `dwell` seconds at 10 Hz a point, eleven levels within ±`noise` so that nothing stands still.
    changes: of the ideal unit's K, B, G, Ka, Ba, P.
    """
    unit, rate_hz = unit_errors(**changes), 10.0
    rows, segments, t = [], [], 0.0
    count = round(dwell * rate_hz)
    flip = noise * ((7 * np.arange(count) % 11) - 5.0)[:, None] / 5.0

    def hold(label: dict[str, Any], rate: np.ndarray, force: np.ndarray) -> None:
        nonlocal t
        rows.append(_stretch(rate, force, unit) + flip)
        segments.append({**label, "t_start": t, "t_end": t + dwell})
        t = round(t + dwell, 6)

    for i in range(3):
        for sign, mark in ((1, "+"), (-1, "-")):
            up = np.eye(3)[i] * sign
            for turn in (0, 180):
                label = {
                    "name": f"position_{mark}{AXES[i]}_{turn:03d}",
                    "kind": "static",
                    "item": "twelve_position",
                    "up": mark + AXES[i],
                    "turn_deg": turn,
                }
                hold(label, np.zeros(3), up * gravity)
    for j in range(3):
        up = np.eye(3)[j]
        rest = {"kind": "static", "item": "rate_sensitivity", "up": "+" + AXES[j]}
        hold({"name": f"rest_{AXES[j]}", **rest}, np.zeros(3), up * gravity)
        for rate in RATES:
            label = {
                "name": f"rate_{AXES[j]}_{rate:+.0f}",
                "kind": "rate",
                "axis": AXES[j],
                "item": "scale_factor",
                "up": "+" + AXES[j],
                "rate_deg_s": rate,
            }
            hold(label, up * np.radians(rate), up * gravity)
        hold({"name": f"rest2_{AXES[j]}", **rest}, np.zeros(3), up * gravity)
    values = np.concatenate(rows)
    manifest = manifest_of(
        "ideal",
        {"latitude_deg": 0.0, "gravity_m_s2": gravity},
        standard="JJF 2003-2022",
        table_time={"commanded_rate": {"half_width": 1e-5, "distribution": "rectangular"}},
        segments=segments,
    )
    columns = dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))
    columns["temperature"] = np.full(len(values), 28.0)
    times = np.round(np.arange(len(values)) / rate_hz, 9)
    air = np.arange(0.0, t, 1.0)
    room = {"temperature": 20.0, "humidity": 50.0, "supply_voltage": 5.0}
    environment = Stream(air, {name: np.full(len(air), value) for name, value in room.items()})
    return Recording(manifest, Stream(times, columns), environment=environment, digest="0" * 64)
