"""Explanations with arrays made by hand, small enough to write a report in a moment."""

from dataclasses import replace
from typing import Any

import numpy as np

from schemas.discrepancy import (
    Consequence,
    Discrepancy,
    FoundParameter,
    HeldOut,
    VerdictChange,
    Where,
)
from schemas.recording import Manifest, Recording, Stream
from schemas.text import Statement
from tasks.explain.correction.consequences import Consequences
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.explain.report import discrepancy_of

RATE_HZ, DWELL, PAUSE = 20.0, 30.0, 3.0
SIGMA = np.array([1e-3] * 3 + [1e-2] * 3)
LABELS: tuple[dict[str, Any], ...] = (
    {"name": "position_+x_000", "kind": "static", "up": "+x"},
    {"name": "position_-x_000", "kind": "static", "up": "-x"},
    {"name": "rate_x_+100", "kind": "rate", "axis": "x", "rate_deg_s": 100.0},
    {"name": "rate_x_-100", "kind": "rate", "axis": "x", "rate_deg_s": -100.0},
    {"name": "turns_z", "kind": "rotation", "axis": "z", "angle_deg": 3600.0},
)
TILT = FoundParameter(name="east", value=1.234e-3, unit="rad", u=1.1e-5)


def recording(noise: float = 1.0, labelled: bool = True, digest: str = "ab12") -> Recording:
    """Five stretches of 30 s with 3 s between, 20 Hz: white noise alone."""
    segments, t = [], 0.0
    for label in LABELS:
        segments.append({**label, "t_start": t + PAUSE, "t_end": t + PAUSE + DWELL})
        t += PAUSE + DWELL
    times = np.arange(round(t * RATE_HZ)) / RATE_HZ
    written = np.random.default_rng(7).normal(size=(len(times), 6)) * SIGMA * noise
    manifest = Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": "run <7> & more",
        "unit": {"manufacturer": "M", "model": "U", "serial": "1"}, "station": {"id": "bench"},
        "segments": segments if labelled else None,
    })  # fmt: skip
    return Recording(manifest, Stream(times, dict(zip(CHANNELS, written.T, strict=True))),
                     digest=digest)  # fmt: skip


def added_to(run: Recording, contribution: np.ndarray) -> Recording:
    """The recording with something added to its readings."""
    written = run.imu.stack(CHANNELS) + contribution
    return replace(run, imu=Stream(run.imu.t, dict(zip(CHANNELS, written.T, strict=True))))


def tilt(size: float = 0.05) -> np.ndarray:
    """(n, 6) an offset of accelerometer x in the first rest, and a swing of y in the turns."""
    t = recording().imu.t
    contribution = np.zeros((len(t), 6))
    contribution[(t >= 3) & (t < 33), 3] = size
    contribution[(t >= 135) & (t < 165), 4] = size * np.sin(2.0 * t[(t >= 135) & (t < 165)])
    return contribution


def finding(contribution: np.ndarray | None = None, **more: Any) -> Finding:
    written: dict[str, Any] = {
        "effect": "axis_tilt", "family": "geometry",
        "title": Statement(en="Table not level", zh="转台不水平"),
        "equation": "u = R(φ)·up, a < b", "source": "rigid-body kinematics", "channels": (3, 4),
        "parameters": (TILT,), "contribution": tilt() if contribution is None else contribution,
        "gain": 900.0, "delta_bic": 512.3, "held_out_gain": 240.1, "share": 0.62,
    }  # fmt: skip
    return Finding(**(written | more))


def unnamed(**more: Any) -> Finding:
    written = {
        "effect": "unnamed", "family": "unnamed",
        "title": Statement(en="a relaxation of 12 s after each move", zh="每次运动后 12 s 的松弛"),
        "parameters": (), "equation": "", "source": "",
    }  # fmt: skip
    return finding(**(written | more))


def explanation(*findings: Finding, verdict: str = "", **more: Any) -> Explanation:
    total = sum((each.contribution for each in findings), np.zeros_like(tilt()))
    run = added_to(recording(), total)
    written: dict[str, Any] = {
        "recording": run, "nominal": np.zeros_like(total), "found": total, "noise": SIGMA,
        "p_value": 1e-30 if findings else 0.41, "findings": findings,
        "verdict": verdict or ("explained" if findings else "no_mismatch"),
        "held_out": HeldOut(rms_ratio={"accel_x": 0.31} if findings else {},
                            chi2_per_dof_before=2.914 if findings else 1.004,
                            chi2_per_dof_after=1.021 if findings else 1.004),
        "explained_share": sum(each.share for each in findings),
        "left_over": np.array([1.02, 1.0, 1.0, 1.31, 1.0, 1.0]),
    }  # fmt: skip
    return Explanation(**(written | more))


def where(channel: str = "accel_x", share: float = 1.0, **more: Any) -> Where:
    written: dict[str, Any] = {
        "channel": channel, "dimension": "attitude", "share": share,
        "description": Statement(en="while +x is up", zh="+x 朝上时"),
        "segments": ("position_+x_000",),
    }  # fmt: skip
    return Where(**(written | more))


BIAS = Consequence(
    item="accel_bias", element="x", before=0.0121, after=0.0001, U=0.0003, unit="m/s2"
)
CHANGE = VerdictChange(item="accel_bias", before="fail", after="pass")


def answer(
    explained: Explanation,
    consequences: tuple[Consequence, ...] = (),
    changes: tuple[VerdictChange, ...] = (),
) -> Discrepancy:
    """What is said when every finding sits in accelerometer x and has the same consequences."""
    count = len(explained.findings)
    effects = Consequences(
        (consequences,) * count, (changes,) * count, consequences if count else (),
        changes if count else (),
    )  # fmt: skip
    return discrepancy_of(explained, [(where(),)] * count, effects)


def located(explained: Explanation, *places: tuple[Where, ...]) -> Discrepancy:
    """The answer with the places of each finding, and without consequences."""
    count = len(explained.findings)
    return discrepancy_of(explained, places, Consequences(((),) * count, ((),) * count))
