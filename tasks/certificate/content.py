"""What the certificate says, as plain rows: clause 8 a) to l), every label in both languages.

The template lays out only; no sentence and no number is made there. A pair is (Chinese,
English); a pair whose two texts are the same is printed once.
"""

from dataclasses import dataclass
from datetime import date

from schemas.certificate import Certificate, Party
from tasks.certificate.names import RULES, VERDICTS, Pair
from tasks.certificate.notes import basis, readings, remarks, uncertainty
from tasks.certificate.results import Section, sections
from tasks.uncertainty.rounding import MINUS

NOT_GIVEN = ("未提供", "not given")

OBJECTS = {
    "JJF 2003-2022": ("微惯性测量组合（MIMU）", "Micro inertial measurement unit (MIMU)"),
    "JJF 1536-2015": ("捷联式惯性航姿仪", "Strapdown inertial flight attitude unit"),
}
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
SPECIFICATIONS = {
    "jjf2003": ("JJF 2003—2022", "JJF 2003-2022"),
    "joint": ("参照 JJF 2003—2022", "after JJF 2003-2022"),
    "jjf1536": ("JJF 1536—2015", "JJF 1536-2015"),
}
WATERMARKS = {
    "draft": ("草稿", "DRAFT"),
    "checked": ("未签发", "NOT ISSUED"),
    "issued": None,
    "amended": ("已更改", "AMENDED"),
    "withdrawn": ("已撤销", "WITHDRAWN"),
}
MARKS = (
    "“—”：未规定允许限；“未得”：未能得到该值，原因见表下",
    "—: no limit is laid down; not determined: no value, the reason stands under the table",
)
NOT_ISSUED = ("尚未签发", "not yet issued")


@dataclass(frozen=True)
class Field:
    """A label and what stands beside it."""

    label: Pair
    value: Pair


@dataclass(frozen=True)
class Signature:
    """A place to sign: the role, the name, the title where there is one, and the date."""

    role: Pair
    name: Pair
    title: Pair | None
    date: Pair | None


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
    signatures: tuple[Signature, ...]
    statement: Pair
    standards: tuple[tuple[Pair, str, str, str, str], ...]
    environment: tuple[tuple[Pair, Pair, str], ...]
    sections: tuple[Section, ...]
    uncertainty: tuple[Pair, ...]
    conformity: tuple[Field, ...]
    reasons: tuple[Pair, ...]
    readings: tuple[tuple[str, str, Pair], ...]
    remarks: tuple[Pair, ...]
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
        laboratory=_name(laboratory.party if laboratory else None),
        laboratory_address=_address(laboratory.party if laboratory else None),
        front=_front(certificate, specification),
        verdict=decision.verdict,
        verdict_text=VERDICTS[decision.verdict],
        signatures=_signatures(certificate),
        statement=basis(calibration, specification),
        standards=_standards(certificate),
        environment=_environment(certificate, specification),
        sections=sections(calibration, decision, specification),
        uncertainty=uncertainty(calibration),
        conformity=_conformity(certificate),
        reasons=_pairs(decision.reasons_zh, decision.reasons),
        readings=readings(calibration),
        remarks=remarks(calibration),
        trace=_trace(certificate),
    )


def literal(text: str) -> str:
    """A text of the user on one line: what has no glyph (control characters) is a space."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _given(zh: str | None, en: str | None = None) -> Pair:
    """Both languages, one for both where only one is there, or «not given»."""
    first, second = literal(zh or ""), literal(en or "")
    return (first or second, second or first) if first or second else NOT_GIVEN


def _name(party: Party | None) -> Pair:
    return _given(party.name_zh, party.name) if party else NOT_GIVEN


def _address(party: Party | None) -> Pair:
    return _given(party.address_zh, party.address) if party else NOT_GIVEN


def _day(day: date | None) -> Pair:
    return _given(day.isoformat() if day else None)


def _pairs(zh: tuple[str, ...], en: tuple[str, ...]) -> tuple[Pair, ...]:
    """Sentences side by side; the English one stands in where the Chinese one is missing."""
    padded = (*zh, *[""] * (len(en) - len(zh)))
    return tuple(_given(*pair) for pair in zip(padded, en, strict=False))


def _front(certificate: Certificate, specification: str) -> tuple[Field, ...]:
    """Clause 8 e), f), g) and clause 9."""
    unit, order = certificate.manifest.unit, certificate.order
    client = order.client if order else None
    return (
        Field(("送校单位", "Client"), _name(client)),
        Field(("送校单位地址", "Address of the client"), _address(client)),
        Field(("被校对象名称", "Object"), OBJECTS[specification]),
        Field(("制造厂", "Manufacturer"), _given(unit.manufacturer)),
        Field(("型号规格", "Model"), _given(unit.model)),
        Field(("编号", "Serial number"), _given(unit.serial)),
        Field(("校准规范", "Specification"), SPECIFICATIONS[certificate.calibration.method]),
        Field(("接收日期", "Date of receipt"), _day(order.received if order else None)),
        Field(("校准日期", "Date of calibration"), _day(certificate.calibrated_on)),
        Field(("建议复校日期", "Recalibration due"), _day(certificate.due)),
    )


def _signatures(certificate: Certificate) -> tuple[Signature, ...]:
    """Clause 8 k), l)."""
    lab = certificate.laboratory
    waiting = certificate.state in ("draft", "checked")
    issued = NOT_ISSUED if waiting else _day(certificate.issued_on)
    title = _given(lab.issuer_title_zh, lab.issuer_title) if lab else NOT_GIVEN
    return (
        Signature(("校准员", "Operator"), _given(lab.operator if lab else None), None, None),
        Signature(("核验员", "Checked by"), _given(lab.checker if lab else None), None, None),
        Signature(("签发人", "Issued by"), _given(lab.issuer if lab else None), title, issued),
    )


def _standards(certificate: Certificate) -> tuple[tuple[Pair, str, str, str, str], ...]:
    """Clause 8 h): name, serial number, accuracy, certificate number, valid until."""
    missing = " ".join(NOT_GIVEN)
    equipment = certificate.laboratory.equipment if certificate.laboratory else ()
    rows = [
        (
            _given(each.name_zh, each.name),
            literal(each.serial) or missing,
            literal(each.accuracy) or missing,
            literal(each.certificate) or missing,
            literal(each.valid_until or "") or missing,
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
    return _given(f"{low} {unit} … {high} {unit}")


def _conformity(certificate: Certificate) -> tuple[Field, ...]:
    decision = certificate.decision
    rule = RULES.get(decision.rule, (decision.rule, decision.rule))
    return (
        Field(("判定依据", "Limits from"), _given(decision.document)),
        Field(("判定规则", "Decision rule"), rule),
        Field(("记号", "Marks"), MARKS),
        Field(("结论", "Verdict"), VERDICTS[decision.verdict]),
    )


def _trace(certificate: Certificate) -> tuple[Field, ...]:
    """Where the result comes from, so that it can be made again."""
    made, station = certificate.calibration, certificate.manifest.station
    gravity = f"{station.gravity_m_s2:g} m/s²" if station.gravity_m_s2 is not None else None
    latitude = f"{station.latitude_deg:g}°" if station.latitude_deg is not None else None
    settings = "; ".join(f"{name} = {value}" for name, value in made.settings.items())
    turn = ", ".join(f"{part:g}" for part in certificate.manifest.mount.quaternion_wxyz)
    return (
        Field(("记录", "Recording"), _given(made.recording_id)),
        Field(("运行", "Run"), _given(made.run)),
        Field(("原始数据摘要", "Digest of the raw data"), _given(made.digest)),
        Field(("计算方法", "Method"), METHODS[made.method]),
        Field(("校准程序", "Procedure"), _given(made.procedure)),
        Field(("软件版本", "Code version"), _given(made.code_version)),
        Field(("设置", "Settings"), _given(settings)),
        Field(("校准装置", "Station"), _given(station.id)),
        Field(("安装姿态", "Mounting quaternion (w, x, y, z)"), _given(turn)),
        Field(("当地重力", "Local gravity"), _given(gravity)),
        Field(("纬度", "Latitude"), _given(latitude)),
    )
