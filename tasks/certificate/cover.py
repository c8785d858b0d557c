"""The first page: who, what, when (clause 8 a to g, k, l; clause 9), the verdict and its scope."""

from dataclasses import dataclass

from schemas.calibration import Calibration
from schemas.certificate import Certificate, Party
from schemas.tolerance import Decision
from tasks.certificate.appendix import TABLE_ITEMS
from tasks.certificate.fields import NOT_GIVEN, Field, day, given
from tasks.certificate.names import Pair, verdict_words
from tasks.certificate.notes import deviates
from tasks.specifications.items import ITEMS

OBJECTS = {
    "JJF 2003-2022": ("微惯性测量组合（MIMU）", "Micro inertial measurement unit (MIMU)"),
    "JJF 1536-2015": ("捷联式惯性航姿仪", "Strapdown inertial flight attitude unit"),
}
SPECIFICATIONS = {
    "jjf2003": ("JJF 2003—2022", "JJF 2003-2022"),
    "joint": ("参照 JJF 2003—2022", "after JJF 2003-2022"),
    "jjf1536": ("JJF 1536—2015", "JJF 1536-2015"),
}
DEVIATING = ("参照 {}，有偏离，见“说明”", "{}, with deviations, see Remarks")
NOT_ISSUED = ("尚未签发", "not yet issued")
NO_STATEMENT = ("未作符合性判定", "no statement of conformity")
SCOPES = {
    "pass": ("所判定项目合格：{total} 项中判定 {n} 项",
             "pass for the {n} of {total} items that have limits"),
    "fail": ("{total} 项中 {n} 项有允许限，判定 {decided} 项，其中 {failed} 项不合格",
             "{n} of {total} items have limits; {decided} were decided on, {failed} of them fail"),
    "inconclusive": ("{total} 项中 {n} 项有允许限，其中 {decided} 项可逐项判定",
                     "{n} of {total} items have limits; {decided} of them could be decided on"),
}  # fmt: skip
IN_PART = ("（其中 {} 项仅判定部分元素）", " ({} of them in part)")
NEAR = ("；{} 项有元素距允许限小于 U", "; {} with an element within U of a limit")


@dataclass(frozen=True)
class Signature:
    """A place to sign: the role, the name, the title where there is one, and the date."""

    role: Pair
    name: Pair
    title: Pair | None
    date: Pair | None


def party_name(party: Party | None) -> Pair:
    return given(party.name_zh, party.name) if party else NOT_GIVEN


def party_address(party: Party | None) -> Pair:
    return given(party.address_zh, party.address) if party else NOT_GIVEN


def front(certificate: Certificate, specification: str) -> tuple[Field, ...]:
    """Clause 8 e), f), g) and clause 9."""
    unit, order = certificate.manifest.unit, certificate.order
    client = order.client if order else None
    return (
        Field(("送校单位", "Client"), party_name(client)),
        Field(("送校单位地址", "Address of the client"), party_address(client)),
        Field(("被校对象名称", "Object"), OBJECTS[specification]),
        Field(("制造厂", "Manufacturer"), given(unit.manufacturer)),
        Field(("型号规格", "Model"), given(unit.model)),
        Field(("编号", "Serial number"), given(unit.serial)),
        Field(("校准规范", "Specification"), _followed(certificate.calibration)),
        Field(("接收日期", "Date of receipt"), day(order.received if order else None)),
        Field(("校准日期", "Date of calibration"), day(certificate.calibrated_on)),
        Field(("建议复校日期", "Recalibration due"), _due(certificate)),
    )


def _followed(calibration: Calibration) -> Pair:
    zh, en = SPECIFICATIONS[calibration.method]
    if not deviates(calibration):
        return zh, en
    return DEVIATING[0].format(zh.removeprefix("参照 ")), DEVIATING[1].format(en)


def _due(certificate: Certificate) -> Pair:
    when = certificate.due.isoformat()
    if certificate.calibrated_on:
        return given(when)
    return (
        f"{when}（未提供校准日期，自证书日期起算）",
        f"{when}, counted from the date of the certificate, as that of the calibration is "
        "not given",
    )


def signatures(certificate: Certificate) -> tuple[Signature, ...]:
    """Clause 8 k), l)."""
    lab = certificate.laboratory
    waiting = certificate.state in ("draft", "checked")
    issued = NOT_ISSUED if waiting else day(certificate.issued_on)
    title = given(lab.issuer_title_zh, lab.issuer_title) if lab else NOT_GIVEN
    return (
        Signature(("校准员", "Operator"), given(lab.operator if lab else None), None, None),
        Signature(("核验员", "Checked by"), given(lab.checker if lab else None), None, None),
        Signature(("签发人", "Issued by"), given(lab.issuer if lab else None), title, issued),
    )


def verdict(decision: Decision) -> Pair:
    """The verdict in words; without any limit there is no statement of conformity."""
    return verdict_words(decision) if decision.limits else NO_STATEMENT


def scope(decision: Decision, specification: str) -> Pair | None:
    """How many of the items the verdict speaks of; None where it speaks of none."""
    if not decision.limits:
        return None
    limited = dict.fromkeys(made.item for made in decision.limits)
    failed = {made.item for made in decision.limits if made.verdict == "fail"}
    unsettled = {made.item for made in decision.limits if made.verdict == "inconclusive"}
    counts = {
        "n": len(limited),
        "total": len({*TABLE_ITEMS[specification], *limited}),
        "failed": len(failed),
        "decided": len(failed | (limited.keys() - unsettled)),
    }
    part = sum(not _whole(decision, item) for item in limited)
    near = len({made.item for made in decision.limits if made.marginal})
    said = tuple(
        text.format(**counts)
        + (tail.format(part) if part else "")
        + (close.format(near) if near else "")
        for text, tail, close in zip(SCOPES[decision.verdict], IN_PART, NEAR, strict=True)
    )
    return said[0], said[1]


def _whole(decision: Decision, item: str) -> bool:
    """Whether every element that the specification names has a limit."""
    named = ITEMS[item].elements if item in ITEMS else ()
    seen = {made.element for made in decision.limits if made.item == item}
    return seen == {"all"} or seen >= set(named)
