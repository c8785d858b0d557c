"""A certificate with capabilities: one U in PDF, DCC and decision, and accreditation or not."""

import math
from typing import Any

import pytest
from lxml import etree
from sample_certificate import (
    calibration,
    certificate,
    content,
    items,
    laboratory,
    tolerance,
    with_budgets,
)

from schemas.capability import Capability
from schemas.certificate import Certificate
from tasks.certificate.dcc import dcc_of
from tasks.certificate.documents import record_of
from tasks.conformity import as_stated, decide
from tasks.specifications.items import ITEMS, item_title
from tasks.words import Message, say

SI = "{https://ptb.de/si}"
EVERY = tuple(
    Capability(item=name, unit=ITEMS[name].unit, U=1e-9) for name in items() if name != "gyro_bias"
)
BIAS = Capability(item="gyro_bias", unit="deg/s", U=4.2e-3)  # evaluated: 3.42e-4


def made(*capabilities: Capability, **more: Any) -> Certificate:
    of = laboratory(accreditation="CNAS L1234", capabilities=capabilities)
    result = calibration()
    decision = decide(as_stated(result, capabilities), tolerance())
    return certificate(result, decision, laboratory=of, **more)


def group(printed: Any, title: Message) -> Any:
    groups = [each for section in printed.sections for each in section.groups]
    return next(each for each in groups if each.title[1] == say(title, "en"))


def texts(printed: Any) -> str:
    return " ".join(sentence[1] for sentence in (*printed.statement, *printed.uncertainty))


def accreditation(printed: Any) -> list[str]:
    return [f.value[1] for f in printed.laboratory_fields if f.label[1] == "Accreditation"]


def expanded_of(document: bytes, label: str) -> str:
    for real in etree.fromstring(document).iter(f"{SI}real"):
        if real.findtext(f"{SI}label") == label:
            return next(real.iter(f"{SI}valueExpandedMU")).text or ""
    raise AssertionError(label)


def test_u_decided_and_printed_everywhere_is_the_capability_and_the_result_keeps_its_own() -> None:
    paper = made(*EVERY, BIAS)
    printed = content(paper)
    bias = group(printed, item_title("gyro_bias"))
    assert ({row.U for row in bias.rows}, bias.exponent) == ({"0.0042"}, 0)
    U = float(expanded_of(dcc_of(paper), "gyro_bias.x"))
    assert pytest.approx(math.radians(4.2e-3)) == U
    decided = {each.U for each in paper.decision.limits if each.item == "gyro_bias"}
    assert decided == {4.2e-3}
    assert paper.calibration.items["gyro_bias"].U["x"] == 2 * 1.71e-4
    assert b'"U":{"x":0.000342' in record_of(paper).replace(b" ", b"").replace(b"\n", b"")
    assert "the evaluated U is smaller, and the capability is stated" in texts(printed)


def test_a_certificate_whose_items_are_all_covered_refers_to_the_accreditation() -> None:
    printed = content(made(*EVERY, BIAS))
    assert accreditation(printed) == ["CNAS L1234"]
    assert "CNAS L1234" in dcc_of(made(*EVERY, BIAS)).decode()
    assert "outside its accreditation" not in texts(printed)


def test_an_item_that_is_not_covered_leaves_no_accreditation_on_the_certificate() -> None:
    paper = made(*EVERY)
    printed = content(paper)
    assert accreditation(printed) == []
    root = etree.fromstring(dcc_of(paper))
    assert root.find(".//{https://ptb.de/dcc}calibrationLaboratoryCode") is None
    assert "which are outside its accreditation" in texts(printed)
    assert "bias" in texts(printed).split("do not cover", 1)[1].split(", which")[0].lower()
    assert "不在认可范围内" in " ".join(sentence[0] for sentence in printed.statement)


def test_budgets_print_the_stated_u_and_say_so() -> None:
    """u_c stays what was evaluated: the line says why U is not k·u_c."""
    result = calibration(items=with_budgets(items()))
    of = laboratory(capabilities=(BIAS.model_copy(update={"U": 0.42}),))
    paper = certificate(result, decide(result, None), laboratory=of, budgets=True)
    assert "the capability is stated in its place" in texts(content(paper))
    printed = content(paper).budgets
    bias = next(each for each in printed.tables if each.title[1] == "Gyro bias")
    assert {element.U for element in bias.elements} == {"0.42"}
    plain = content(certificate(result, decide(result, None), budgets=True)).budgets
    assert printed.tables[0] == plain.tables[0]
    kept = [next(t for t in each.tables if t.title == bias.title) for each in (printed, plain)]
    assert [e.u_c for e in kept[0].elements] == [e.u_c for e in kept[1].elements]
