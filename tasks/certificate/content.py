"""What the certificate says, as plain rows: clause 8 a) to l), every label in both languages.

The template lays out only; no sentence and no number is made there. A pair is (Chinese,
English); a pair whose two texts are the same is printed once.
"""

from dataclasses import dataclass

from schemas.certificate import Certificate
from tasks.certificate import cover
from tasks.certificate.budgets import Budgets, budgets
from tasks.certificate.conditions import Conditions, conditions
from tasks.certificate.cover import Signature
from tasks.certificate.decisions import conditions_of_a_pass, conformity
from tasks.certificate.fields import NOT_GIVEN, Field, given, literal, number
from tasks.certificate.information import InformationRow, information_rows
from tasks.certificate.names import Pair
from tasks.certificate.notes import basis, head_of_results, readings, reasons, remarks, uncertainty
from tasks.certificate.results import Section, sections
from tasks.words.rounding import MINUS

# Clause 6 of the one, 6.2.1 of the other: °C, %RH.
CONDITIONS = {
    "JJF 2003-2022": ("(20 ± 5) °C", "20 % … 85 %"),
    "JJF 1536-2015": ("(20 ± 3) °C", "30 % … 85 %"),
}
METHODS = {
    "jjf2003": ("JJF 2003—2022 各条款", "JJF 2003-2022, clause by clause"),
    "joint": ("联合最小二乘", "joint least squares"),
    "jjf1536": ("JJF 1536—2015 各条款", "JJF 1536-2015, clause by clause"),
}
WATERMARKS = {
    "draft": ("草稿", "DRAFT"),
    "checked": ("未签发", "NOT ISSUED"),
    "issued": None,
    "amended": ("已更改", "AMENDED"),
    "withdrawn": ("已撤销", "WITHDRAWN"),
}


@dataclass(frozen=True)
class Content:
    """The whole certificate in the order in which it is printed."""

    number: str
    title: Pair
    watermark: Pair | None
    laboratory: Pair
    laboratory_address: Pair
    front: tuple[Field, ...]
    verdict: str
    verdict_text: Pair
    scope: Pair | None
    uncertainty_in_short: Pair | None
    signatures: tuple[Signature, ...]
    statement: tuple[Pair, ...]
    standards: tuple[tuple[Pair, str, str, str, str], ...]
    environment: tuple[tuple[Pair, Pair, str], ...]
    conditions: Conditions
    sections: tuple[Section, ...]
    information: tuple[InformationRow, ...]
    uncertainty: tuple[Pair, ...]
    conformity: tuple[Field, ...]
    reasons: tuple[Pair, ...]
    readings: tuple[tuple[str, Pair, Pair], ...]
    remarks: tuple[Pair, ...]
    budgets: Budgets | None
    trace: tuple[Field, ...]


def content(certificate: Certificate) -> Content:
    """Everything the certificate prints."""
    calibration, decision = certificate.calibration, certificate.decision
    laboratory = certificate.laboratory
    specification = "JJF 1536-2015" if calibration.method == "jjf1536" else "JJF 2003-2022"
    return Content(
        number=literal(certificate.number),
        title=("校准证书", "Calibration Certificate"),
        watermark=WATERMARKS[certificate.state],
        laboratory=cover.party_name(laboratory.party if laboratory else None),
        laboratory_address=cover.party_address(laboratory.party if laboratory else None),
        front=cover.front(certificate, specification),
        verdict=decision.verdict,
        verdict_text=cover.verdict(decision),
        scope=cover.scope(decision, specification),
        uncertainty_in_short=head_of_results(calibration),
        signatures=cover.signatures(certificate),
        statement=basis(calibration, specification),
        standards=_standards(certificate),
        environment=_environment(certificate, specification),
        conditions=conditions(calibration, certificate.manifest),
        sections=sections(calibration, decision, specification),
        information=information_rows(calibration),
        uncertainty=(*uncertainty(calibration), *_validation(certificate)),
        conformity=conformity(decision),
        reasons=(*reasons(calibration, decision), *conditions_of_a_pass(decision)),
        readings=readings(calibration),
        remarks=remarks(calibration),
        budgets=budgets(calibration) if certificate.budgets else None,
        trace=_trace(certificate),
    )


def _validation(certificate: Certificate) -> tuple[Pair, ...]:
    """Which record validates the estimation."""
    if certificate.validation is None:
        return ()
    en, zh = certificate.validation
    return ((f"{zh}。", f"{en}."),)


def _standards(certificate: Certificate) -> tuple[tuple[Pair, str, str, str, str], ...]:
    """Clause 8 h): name, serial number, accuracy, certificate number, valid until."""
    missing = " ".join(NOT_GIVEN)
    equipment = certificate.laboratory.equipment if certificate.laboratory else ()
    rows = [
        (
            given(each.name_zh, each.name),
            literal(each.serial) or missing,
            literal(each.accuracy) or missing,
            literal(each.certificate) or missing,
            each.valid_until.isoformat() if each.valid_until else missing,
        )
        for each in equipment
    ]
    return tuple(rows) or ((NOT_GIVEN, missing, missing, missing, missing),)


def _environment(
    certificate: Certificate, specification: str
) -> tuple[tuple[Pair, Pair, str], ...]:
    """Clause 8 i): what was seen during the run, and what clause 6 asks for."""
    seen = certificate.calibration.environment
    temperature, humidity = CONDITIONS[specification]
    return (
        (("环境温度", "Air temperature"), _range(seen.temperature_degc, "°C"), temperature),
        (("相对湿度", "Relative humidity"), _range(seen.humidity_percent, "%"), humidity),
    )


def _range(seen: tuple[float, float] | None, unit: str) -> Pair:
    if seen is None:
        return NOT_GIVEN
    low, high = (f"{value:.1f}".replace("-", MINUS) for value in seen)
    return given(f"{low} {unit} … {high} {unit}")


def _trace(certificate: Certificate) -> tuple[Field, ...]:
    """Where the result comes from, so that it can be made again."""
    made, station = certificate.calibration, certificate.manifest.station
    gravity, latitude = station.gravity_m_s2, station.latitude_deg
    settings = "; ".join(f"{name} = {value}" for name, value in made.settings.items())
    return (
        Field(("记录", "Recording"), given(made.recording_id)),
        Field(("运行", "Run"), given(made.run)),
        Field(("原始数据摘要", "Digest of the raw data"), given(made.digest)),
        Field(("计算方法", "Method"), METHODS[made.method]),
        Field(("校准程序", "Procedure"), given(made.procedure)),
        Field(("软件版本", "Code version"), given(made.code_version)),
        Field(("设置", "Settings"), given(settings)),
        Field(("校准装置", "Station"), given(station.id)),
        Field(
            ("当地重力", "Local gravity"),
            given(None if gravity is None else f"{number(gravity)} m/s²"),
        ),
        Field(("纬度", "Latitude"), given(None if latitude is None else f"{number(latitude)}°")),
    )
