"""Small recordings, results and certificates, made up."""

from datetime import date
from typing import Any

import numpy as np

from schemas.calibration import Calibration, Item
from schemas.certificate import Certificate
from schemas.recording import ACCEL, GYRO, Recording, Stream
from schemas.tolerance import Decision
from storage.catalogue.runs import Run
from tests.manifests import manifest_of


def small(start: float = 0.0, name: str = "small", serial: str = "1") -> Recording:
    """A recording of three seconds; `start` makes its content another one."""
    manifest = manifest_of(
        name, {"id": "T1"}, unit={"manufacturer": "Maker", "model": "U", "serial": serial}
    )
    t = np.round(np.arange(300) / 100, 9)
    values = {n: np.sin(start + t + k) for k, n in enumerate(GYRO + ACCEL)}
    return Recording(manifest, Stream(t, values))


def calibrated(run: Run, bias: float = 0.25, **changes: Any) -> Calibration:
    """The result of a run; `bias` makes it another one."""
    item = Item(
        unit="deg/s", clause="7.2.2", value={"x": bias, "y": None}, u={"x": 0.01, "y": None},
        U={"x": 0.02, "y": None},
    )  # fmt: skip
    fields = {
        "recording_id": run.recording_id, "run": run.id, "digest": run.digest,
        "method": "jjf2003", "code_version": "1", "procedure": "jjf2003", "settings": {},
        "items": {"gyro_bias": item}, "unavailable": {"gyro_bias.y": "no run about y"},
    }  # fmt: skip
    return Calibration.model_validate(fields | changes)


def certified(
    recording: Recording, calibration: Calibration, number: str, **changes: Any
) -> Certificate:
    """A certificate of a result."""
    fields = {
        "number": number, "state": "issued", "calibrated_on": date(2026, 11, 21),
        "issued_on": date(2026, 11, 22), "due": date(2027, 11, 21), "laboratory": None,
        "order": None, "manifest": recording.manifest, "calibration": calibration,
        "decision": Decision(verdict="pass", rule="simple", document=None, limits=()),
    }  # fmt: skip
    return Certificate.model_validate(fields | changes)
