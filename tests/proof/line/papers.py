"""The papers of the line: limits of each model, laboratory, turntables, certificates."""

import hashlib
from datetime import date, timedelta
from typing import Any

from schemas.certificate import Certificate, Laboratory, Order, Party, Step
from schemas.equipment import MeasurementStandard
from schemas.recording import Manifest
from schemas.tolerance import Limit, Tolerance
from tasks.stages.certify import due_date
from tests.proof.line.draw import BEGINNING, MODELS, STATIONS, LineUnit, station_name
from tests.proof.line.visits import LineRun

MAKER = "Plant"
INTERVALS = (3, 6, 12)  # months
CLIENTS = ("North Works", "Client & Co", "Harbour Instruments")
LIMITS = (
    ("gyro_scale_factor", "1", 0.016), ("gyro_cross_coupling", "1", 0.0068),
    ("gyro_bias", "deg/s", 0.65), ("gyro_g_sensitivity", "(deg/s)/g", 0.028),
    ("accel_scale_factor", "1", 0.016), ("accel_cross_coupling", "1", 0.0068),
    ("accel_bias", "m/s2", 0.12), ("accel_rate_sensitivity", "m", 0.0014),
)  # fmt: skip
ONE_SIDED = "MX-400"  # its scale factors have a lower limit alone
LABORATORY = Laboratory(
    party=Party(name="Line", name_zh="生产线", address="1 Road", address_zh="路 1 号"),
    certificate_prefix="LINE",
)


def tolerance_of(model: str) -> Tolerance:
    """Limits about three deviations of the production wide."""
    limits = []
    for item, unit, size in LIMITS:
        if item.endswith("scale_factor"):
            one_sided = model == ONE_SIDED
            bounds: dict[str, Any] = {"lower": -size} if one_sided else {"magnitude": size}
            bounds |= {"relative": True, "nominal": 1.0, "U_max": size / 4}
        else:
            bounds = {"magnitude": size}
        limits.append(Limit(item=item, unit=unit, **bounds))
    return Tolerance(
        manufacturer=MAKER, model=model, document=f"data sheet of {model}", limits=tuple(limits)
    )


def turntables() -> list[list[MeasurementStandard]]:
    """Each year's certificate of the turntable of each station, the oldest year first."""
    return [[_turntable(station, year) for station in range(STATIONS)] for year in range(4)]


def turntable_on(station: int, day: date) -> MeasurementStandard:
    """The turntable with the certificate that counts on a day."""
    every = [each[station] for each in turntables()]
    return max(
        (each for each in every if each.calibrated_on and each.calibrated_on <= day),
        key=lambda each: each.calibrated_on or date.min,
    )


def _turntable(station: int, year: int) -> MeasurementStandard:
    begins = (BEGINNING - timedelta(days=40 + 35 * station)).date()
    begins = begins.replace(year=begins.year + year)
    return MeasurementStandard(
        name="Three-axis turntable", name_zh="三轴转台", serial=f"TT-{station_name(station)}",
        accuracy="", certificate=f"TT-{station + 1}-{begins.year}", calibrated_on=begins,
        valid_until=begins + timedelta(days=400),
    )  # fmt: skip


def manifest_of_run(unit: LineUnit, run: LineRun) -> dict[str, Any]:
    """What the manifest says of who, where and when."""
    standard = turntable_on(run.station, run.at.date())
    return {
        "recording_id": f"{unit.serial}-{run.number:03d}",
        "acquired_at": run.at.isoformat(),
        "recorded_at": run.at.isoformat(),
        "procedure": "jjf2003_short",
        "equipment": [
            {"name": standard.name, "serial": standard.serial, "certificate": standard.certificate}
        ],
        "unit": {"manufacturer": MAKER, "model": MODELS[unit.model][0], "serial": unit.serial},
    }


def order_of(unit: LineUnit, run: LineRun) -> Order:
    """The client's order, which agrees on an interval."""
    client = CLIENTS[unit.number % len(CLIENTS)]
    party = Party(name=client, name_zh=client, address="2 Road", address_zh="路 2 号")
    months = INTERVALS[unit.number % len(INTERVALS)]
    return Order(client=party, received=run.at.date(), interval_months=months)


def certificate_of(unit: LineUnit, run: LineRun, manifest: Manifest, number: str) -> Certificate:
    """The certificate of a run: issued where it is the last of its visit, else a draft."""
    order, day, issued = order_of(unit, run), run.at.date(), run.is_last
    standard = turntable_on(run.station, day)
    moment = run.at + timedelta(hours=3)
    names = ("draft", "Wang Li"), ("check", "Zhao Min"), ("issue", "Chen Jie")
    steps = tuple(
        Step.model_validate({"step": step, "person": person, "at": moment})
        for step, person in names[: 3 if issued else 1]
    )
    return Certificate(
        number=number, state="issued" if issued else "draft", calibrated_on=day,
        issued_on=moment.date(), due=due_date(day, order, run.calibration),
        laboratory=LABORATORY.model_copy(update={"equipment": (standard,)}), order=order,
        manifest=manifest, calibration=run.calibration, decision=run.decision, steps=steps,
    )  # fmt: skip


def row_of(certificate: Certificate, run: LineRun, result: str, unit: int) -> dict[str, Any]:
    """A certificate's row of the register, with the name of its record."""
    record = f"certificates/{certificate.number}.json"
    words = certificate.purpose + (" as-left" if run.adjusted else "")
    content = certificate.model_dump_json().encode()
    return {
        "number": certificate.number, "result": result, "run": certificate.calibration.run,
        "unit": unit, "state": certificate.state, "verdict": certificate.decision.verdict,
        "purpose": words, "calibrated_on": certificate.calibrated_on,
        "issued_on": certificate.issued_on, "due": certificate.due,
        "kept_at": run.at + timedelta(hours=3), "pdf": "", "pdf_sha256": "", "record": record,
        "record_sha256": hashlib.sha256(content).hexdigest(),
        "limits": len(certificate.decision.limits),
    }  # fmt: skip
