"""Drafts of certificates for small made-up recordings, one for each serial number."""

from datetime import UTC, date, datetime
from typing import Any

import numpy as np

from schemas.calibration import Calibration, EnvironmentSeen, Item
from schemas.certificate import Certificate, Laboratory, Order, Party, Step
from schemas.laboratory import MeasurementStandard
from schemas.recording import ACCEL, GYRO, Recording, Stream
from schemas.text import texts_fields
from schemas.tolerance import Decision, Limit, LimitDecision, Tolerance
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages.certify import DRAFT, Published, keep_draft
from tasks.words import message, statement
from tests.manifests import manifest_of

MORNING = datetime(2026, 11, 21, 8, tzinfo=UTC)
PARTY = Party(name="Lab", name_zh="实验室", address="1 Road", address_zh="路 1 号")
CLIENT = Party(name="Client", name_zh="送校单位", address="2 Road", address_zh="路 2 号")
ORDER = Order(client=CLIENT, received=date(2018, 1, 1))
TOLERANCE = Tolerance(
    manufacturer="Maker", model="U", document="Data sheet",
    limits=(Limit(item="gyro_bias", unit="deg/s", elements=("x",), magnitude=1.0),),
)  # fmt: skip
STANDARD = MeasurementStandard(
    name="Turntable", name_zh="转台", serial="TT-1", accuracy="1″", certificate="C-1",
    valid_until=date(2099, 12, 31),
)  # fmt: skip
LABORATORY = Laboratory(
    party=PARTY, certificate_prefix="LAB", operator="Wang", equipment=(STANDARD,),
    issuer_title="Head of laboratory", issuer_title_zh="实验室主任",
)  # fmt: skip
AIR = EnvironmentSeen(temperature_degc=(19.5, 20.5), humidity_percent=(40.0, 45.0))
PASSED = LimitDecision(
    item="gyro_bias", element="x", unit="deg/s", applied_to="value", value=0.25, U=0.02,
    lower=-1.0, upper=1.0, verdict="pass",
)  # fmt: skip
UNDECIDED = Decision(
    verdict="inconclusive", rule="simple", document="Data sheet", limits=(PASSED,),
    **texts_fields("reasons", (statement(message("conformity-no-tolerance")),)),
)  # fmt: skip
DECIDED = Decision(verdict="pass", rule="simple", document="Data sheet", limits=(PASSED,))


def recording_of(serial: str) -> Recording:
    """Three seconds of a unit."""
    manifest = manifest_of(
        f"run of {serial}",
        {"id": "T1"},
        unit={"manufacturer": "Maker", "model": "U", "serial": serial},
    )
    t = np.round(np.arange(300) / 100, 9)
    phase = float(sum(serial.encode()))
    return Recording(
        manifest, Stream(t, {n: np.sin(phase + t + k) for k, n in enumerate(GYRO + ACCEL)})
    )


def calibration_of(run: runs.Run, **changes: Any) -> Calibration:
    """A result of one element, by which nothing else than itself is known."""
    bias = changes.pop("bias", 0.25)
    item = Item(unit="deg/s", clause="7.2.2", value={"x": bias}, u={"x": 0.01}, U={"x": 0.02})
    fields = {
        "recording_id": run.recording_id, "run": run.id, "digest": run.digest,
        "method": "jjf2003", "code_version": "1", "procedure": "jjf2003", "settings": {},
        "items": {"gyro_bias": item}, "unavailable": {}, "environment": AIR,
    }  # fmt: skip
    return Calibration.model_validate(fields | changes)


def certificate_of(run: runs.Run, calibration: Calibration, **changes: Any) -> Certificate:
    """A certificate of what Sun measured and Wang drafted, which states all that it has to."""
    fields = {
        "number": DRAFT, "state": "draft", "calibrated_on": date(2026, 11, 20),
        "issued_on": MORNING.date(), "due": date(2027, 11, 20), "laboratory": LABORATORY,
        "order": ORDER, "operator": "Sun", "manifest": recording_of(run.serial).manifest,
        "calibration": calibration,
        "decision": DECIDED, "tolerance": TOLERANCE,
        "steps": (Step(step="draft", person="Wang", at=MORNING),),
    }  # fmt: skip
    return Certificate.model_validate(fields | changes)


def draft(home: Home, serial: str = "1", bias: float = 0.25, **changes: Any) -> Published:
    """Takes in the recording and the result of a unit, and drafts its certificate."""
    run, _ = runs.add(recording_of(serial), home)
    calibration = calibration_of(run, bias=bias)
    results.save(calibration, home)
    return keep_draft(certificate_of(run, calibration, **changes), home, MORNING)
