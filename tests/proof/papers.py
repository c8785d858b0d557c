"""The kinds of certificates a laboratory issues, of simulated units, by either specification."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path

import pypdfium2  # type: ignore[import-untyped]

from schemas.calibration import Calibration, ValidationRecord
from schemas.certificate import (
    AsFound,
    Certificate,
    Laboratory,
    Order,
    Party,
    Replaced,
    Step,
    StepName,
)
from schemas.laboratory import ErrorBound, MeasurementStandard
from schemas.recording import Recording
from schemas.station import configuration_of
from schemas.text import BOTH, CONTRACTED, Remark
from schemas.tolerance import Decision, Tolerance
from storage import settings
from tasks import conformity
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.certificate.content import differences
from tasks.certificate.pdf import faces_of
from tasks.curves import curves_of_run, history
from tasks.specifications.register import BY_STANDARD
from tasks.stages.certify import due_date
from tasks.validation import record
from tasks.validation.coverage import simulate
from tasks.version import code_version
from tasks.words import statement
from tests.own_limits import as_table_1
from tests.proof.study import Out, folder_of

PAPERS = Path(__file__).parents[2] / "flows/demo_papers"
FOLDERS = {"jjf2003": PAPERS, "jjf1536": PAPERS / "ahrs"}
DAY = date(2026, 11, 20)
MORNING = datetime(2026, 11, 20, 8, tzinfo=UTC)
PERSONS: tuple[tuple[StepName, str], ...] = (
    ("draft", "Li Ming"), ("check", "Wang Fang"), ("issue", "Demo Issuer"),
)  # fmt: skip
EQUIPMENT = (
    MeasurementStandard(
        name="Three-axis position and rate table", name_zh="三轴位置速率转台",
        serial="TT3-0417", accuracy="U(rate) = 1×10⁻⁵ (k = 2); position ±10″",
        certificate="T-2026-1", valid_until=date(2027, 3, 14),
        limits={
            "rate": ErrorBound(half_width=1e-5, distribution="normal"),
            "position": ErrorBound(half_width=4.848e-5, distribution="rectangular"),
        },
    ),
    MeasurementStandard(
        name="Thermo-hygrometer", name_zh="温湿度计", serial="TH-2209",
        accuracy="±0.3 °C; ±3 % RH", certificate="T-2026-2", valid_until=date(2027, 5, 2),
    ),
)  # fmt: skip
LONG = Party(
    name="Joint Stock Company for the Development, Production and Maintenance of Navigation and "
    "Stabilisation Systems of the Northern Provinces, Branch for Inertial Measurement",
    name_zh="北方各省导航与稳定系统研制生产维修股份有限责任公司惯性测量技术分公司第三计量检测中心",
    address="Building 14, Entrance C, Industrial Estate “Gyroscope”, 1284 Long Quay Avenue, "
    "Administrative District 7, 518057 Shenzhen, Guangdong, People's Republic of China",
    address_zh="中华人民共和国广东省深圳市南山区陀螺仪工业园长堤大道1284号第14栋C座（518057）",
)
LONG_SERIAL = "SN-2026-NAV-0000417-REV-C-LOT-88213-00000000000000000000000000000042"


def cases(method: str) -> Iterator[tuple[str, Certificate]]:
    """Each kind by its name, in both languages: pass, conditional, fail, inconclusive, an invalid
    run, a draft, an amendment, a withdrawal, an adjusted unit, a report of less, a part of the
    items, long names.
    """
    recording, _ = simulate(method, 3)
    measured = _calibrated(recording)
    whole = measured.model_copy(
        update={"remarks": tuple(r for r in measured.remarks if not r.blocks_pass)}
    )
    given = settings.read(FOLDERS[method] / "tolerance.toml", Tolerance)
    tolerance = _limits(given, wider=5)
    passed = _certificate(recording, whole, tolerance)
    moved = tuple(history(passed, tuple(_earlier(passed))))
    passed = passed.model_copy(update={"curves": (*passed.curves, *moved)})
    assert passed.decision.verdict == "pass", passed.decision.reasons
    yield "pass", passed
    yield "conditional", _certificate(recording, whole, _limits_near(whole, given))
    yield "fail", _certificate(recording, measured, _limits(given, wider=0.02))
    yield "inconclusive", _certificate(recording, _calibrated(recording, own=False), tolerance)
    unlike = Remark(
        code="table_unlike_unit", run="invalid",
        en="The table turned by 3.1° less than the unit says, at rate_x_+100.",
        zh="rate_x_+100：转台转角比被校对象示值小 3.1°。", segments=("rate_x_+100",),
    )  # fmt: skip
    invalid = measured.model_copy(update={"remarks": (unlike, *measured.remarks)})
    yield "invalid", _certificate(recording, invalid, tolerance)
    why = "the client's address was wrong"
    assert passed.order is not None
    replaced = Replaced(number="DEMO-2026-0041", issued_on=date(2026, 11, 20), why=why)
    wrong = passed.order.client.model_copy(update={"address": "2 Gimball Street, Demo City"})
    before = passed.model_copy(update={"order": passed.order.model_copy(update={"client": wrong})})
    replaced = replaced.model_copy(update={"changes": differences(before, passed)})
    yield "amendment", passed.model_copy(update={"replaces": replaced})
    yield "amended", passed.model_copy(update={"state": "amended"})
    yield "withdrawn", passed.model_copy(update={"state": "withdrawn"})
    yield "draft", passed.model_copy(update={"state": "draft", "steps": passed.steps[:1]})
    found = next(_earlier(passed)).calibration
    order_found = passed.order
    assert order_found is not None
    decided = _decision(recording, found, _limits(given, wider=0.02), order_found)
    yield (
        "adjusted",
        passed.model_copy(
            update={"as_found": AsFound(calibrated_on=DAY, calibration=found, decision=decided)}
        ),
    )
    agreed = {"report": "order 4711 of 2026-11-02, clause 5", "operator": None}
    yield "report", passed.model_copy(update=agreed)
    part = _without_z(recording)
    yield "partial", _certificate(part, _calibrated(part), tolerance)
    unit = recording.manifest.unit.model_copy(update={"serial": LONG_SERIAL})
    named = recording.manifest.model_copy(update={"unit": unit})
    order = passed.order.model_copy(update={"client": LONG})
    yield "long-names", passed.model_copy(update={"manifest": named, "order": order})


def _validated() -> ValidationRecord:
    """The shipped record, as one of this code."""
    shipped = record.shipped()
    assert shipped is not None
    return shipped.model_copy(update={"code_version": code_version()})


def _earlier(certificate: Certificate) -> Iterator[Certificate]:
    """Certificates of the years before, since which every coefficient moved by 0.7 of its U."""
    for years in (3, 2, 1):
        items = {
            name: item.model_copy(
                update={
                    "value": {
                        element: value and value + 0.7 * years * (item.U[element] or 0.0)
                        for element, value in item.value.items()
                    }
                }
            )
            for name, item in certificate.calibration.items.items()
        }
        result = certificate.calibration.model_copy(update={"items": items})
        day = DAY.replace(year=DAY.year - years)
        yield certificate.model_copy(
            update={"number": f"DEMO-{day.year}-0017", "calibrated_on": day, "calibration": result}
        )


def _limits(given: Tolerance, wider: float) -> Tolerance:
    """The limits, so many times as wide."""
    limits = (
        limit.model_copy(
            update={"magnitude": wider * limit.magnitude}
            if limit.magnitude
            else {"lower": 1 - wider * 0.002, "upper": 1 + wider * 0.002}
        )
        for limit in given.limits
    )
    return given.model_copy(update={"limits": tuple(limits)})


def _limits_near(result: Calibration, given: Tolerance) -> Tolerance:
    """Limits of which one lies half of U beyond the largest value of its item."""
    near = next(limit for limit in given.limits if limit.magnitude and not limit.relative)
    item = result.items[near.item]
    largest = max(abs(value) for value in item.value.values() if value is not None)
    U = max(U for U in item.U.values() if U is not None)
    tight = near.model_copy(
        update={
            "magnitude": round(largest + 0.5 * U, 5),
            "elements": None,
            "rule": "simple_acceptance",
        }
    )
    return given.model_copy(update={"limits": (tight,), "guard_band_factor": None})


def _without_z(recording: Recording) -> Recording:
    """Only X and Y were turned: what needs rates about Z is not determined."""
    kept = [s for s in recording.manifest.segments or () if s.axis != "z"]
    manifest = recording.manifest.model_copy(update={"segments": tuple(kept)})
    return replace(recording, manifest=manifest)


def _calibrated(recording: Recording, own: bool = True) -> Calibration:
    specification = BY_STANDARD[recording.manifest.standard]
    evaluation = evaluation_for(recording, own=as_table_1() if own else None)
    return calibrate(
        specification, recording, run="4f9c1a7e20b3", code_version="1.0", evaluation=evaluation
    )


def _certificate(recording: Recording, result: Calibration, tolerance: Tolerance) -> Certificate:
    laboratory = settings.read(PAPERS / "laboratory.toml", Laboratory)
    order = settings.read(FOLDERS[result.method] / "order.toml", Order)
    named = statement(record.named(_validated(), result))
    return Certificate(
        number="DEMO-2026-0042",
        state="issued",
        calibrated_on=DAY,
        issued_on=DAY,
        due=due_date(DAY, order, result),
        laboratory=laboratory.model_copy(update={"equipment": EQUIPMENT}),
        order=order,
        manifest=recording.manifest,
        calibration=result,
        decision=_decision(recording, result, tolerance, order),
        budgets=True,
        validation=(named.en, named.zh),
        tolerance=tolerance,
        operator="Li Ming",
        curves=curves_of_run(recording, result),
        steps=tuple(Step(step=step, person=person, at=MORNING) for step, person in PERSONS),
    )


def _decision(
    recording: Recording, result: Calibration, tolerance: Tolerance, order: Order
) -> Decision:
    configuration = configuration_of(recording.manifest.unit, order.configuration)
    deviating = conformity.deviations(result, configuration, order.waived_conditions)
    unmet = (each.printed for each in deviating if not each.waived)
    smaller = conformity.smaller_than_stated(result, EQUIPMENT, MORNING.date())
    bare = conformity.untraceable(EQUIPMENT)
    doubts = record.doubts_of(_validated(), result)
    return conformity.decide(result, tolerance, (*bare, *smaller, *unmet), doubts)


DOTS_PER_POINT = 2.0


def papers(out: Out = None) -> None:
    """Certificates of every kind, to look at: PDF and images, in each setting of the languages."""
    folder = folder_of("papers", out)
    for method in FOLDERS:
        for name, certificate in cases(method):
            for language in (*CONTRACTED, BOTH):
                assert certificate.order is not None
                order = certificate.order.model_copy(update={"language": language})
                pdf = faces_of(certificate.model_copy(update={"order": order}), None).pdf
                _write(folder / f"{method}-{name}-{language}", pdf)
    print(folder)


def _write(folder: Path, pdf: bytes) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "certificate.pdf").write_bytes(pdf)
    for number, page in enumerate(pypdfium2.PdfDocument(pdf), start=1):
        image = page.render(scale=DOTS_PER_POINT).to_pil()
        image.save(folder / f"page-{number:02d}.png")
