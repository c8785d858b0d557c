"""Explanations made by hand: what is added to the readings is known."""

from typing import Any

import numpy as np

from schemas.discrepancy import FoundParameter, HeldOut
from schemas.recording import Recording
from schemas.text import Statement
from tasks.explain.explanation import CHANNELS, Explanation, Finding


def nothing_added(recording: Recording) -> np.ndarray:
    return np.zeros((len(recording.imu.t), len(CHANNELS)))


def finding(contribution: np.ndarray, effect: str = "bias_step", **more: Any) -> Finding:
    fields: dict[str, Any] = {
        "effect": effect, "family": "memory", "title": Statement(en="a step", zh="阶跃"),
        "equation": "b",
        "source": "test", "channels": tuple(np.flatnonzero(contribution.any(axis=0)).tolist()),
        "parameters": (FoundParameter(name="gyro_x", value=0.01, unit="deg/s", u=0.001),),
        "contribution": contribution, "gain": 100.0, "delta_bic": 90.0, "held_out_gain": 40.0,
    }  # fmt: skip
    return Finding(**(fields | more))


def explanation(recording: Recording, *findings: Finding) -> Explanation:
    nominal = nothing_added(recording)
    return Explanation(
        recording=recording, nominal=nominal, noise=np.full(len(CHANNELS), 1e-4), p_value=1e-9,
        found=nominal + sum((each.contribution for each in findings), nominal),
        verdict="explained" if findings else "no_mismatch", findings=findings,
        held_out=HeldOut(rms_ratio={}, chi2_per_dof_before=2.0, chi2_per_dof_after=1.0),
    )  # fmt: skip
