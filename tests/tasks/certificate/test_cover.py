"""What the certificate says about how it was measured and how far its verdict reaches."""

import math
from datetime import date
from typing import Any

import pytest
from lxml import etree
from pydantic import ValidationError

from schemas.calibration import AdoptedTerm, Calibration, SegmentUsed
from schemas.certificate import Certificate, Contact, Replaced
from schemas.discrepancy import FoundParameter
from schemas.recording import Kind, Manifest, Mount, Segment
from schemas.station import Configuration
from schemas.text import Remark
from schemas.tolerance import Capability, Limit
from tasks.certificate.content import Content
from tasks.certificate.dcc import dcc_of
from tasks.certificate.pdf import faces_of, record_bytes
from tasks.conformity import as_stated, decide
from tasks.specifications.estimate import ITEMS, item_title
from tasks.words import Message, say
from tests.tasks.certificate.sample_certificate import (
    AXES,
    adjusted,
    calibration,
    certificate,
    content,
    item,
    items,
    laboratory,
    manifest,
    order,
    tolerance,
    with_budgets,
)


def segment(name: str, kind: Kind, **more: Any) -> SegmentUsed:
    seconds = more.pop("seconds", 30.0)
    return SegmentUsed(
        name=name, kind=kind, t_start=0.0, t_end=seconds, origin="label", rows=100, **more
    )


def turned(**changes: Any) -> Calibration:
    """Two rests, x turned at four points, y at one."""
    used = (
        segment("up", "static", up="+x", seconds=30.02),
        segment("down", "static", up="-x", seconds=29.96),
        *(segment(f"x{r}", "rate", axis="x", up="+x", rate_deg_s=r) for r in (-300, -10, 10, 300)),
        segment("y", "rate", axis="y", up="+y", rate_deg_s=-50.0, seconds=31.0),
    )
    return calibration(segments=used, **changes)


def labelled(**changes: Any) -> Manifest:
    turn = Mount(quaternion_wxyz=(0.0, -1.0, 0.0, 0.0))
    labels = (
        Segment(name="up", kind="static", t_start=0, t_end=30, up="+x", turn_deg=0),
        Segment(name="down", kind="static", t_start=0, t_end=30, up="-x", turn_deg=180, mount=turn),
    )
    return manifest().model_copy(update={"segments": labels} | changes)


def test_the_conditions_tell_rates_dwell_positions_and_mounting():
    made = content(certificate(turned(), manifest=labelled())).conditions
    assert [(r.axis, r.points[1], r.count, r.largest) for r in made.rates] == [
        ("X", "±10, ±300", "4", "300"), ("Y", "−50", "1", "50"), ("Z", "—", "0", "—"),
    ]  # fmt: skip
    assert [field.value[1] for field in made.fields] == [
        "29.9 s at rest; 30.0 s at constant rate",
        "2 rests; 2 directions up: +x, −x; headings 0°, 180° (not each with every axis up)",
        "(1, 0, 0, 0); (0, −1, 0, 0)",
        "not given",
    ]


@pytest.mark.parametrize(
    ("rate_range", "answer"),
    [
        (None, "is not stated, so its inclusion could not be checked"),
        (300, "is 300 °/s; it was not included about Y, Z (up to 0 °/s)"),
        (10, "is 10 °/s; it was not included about Z (up to 0 °/s)"),
    ],
)
def test_a_largest_input_rate_that_was_not_included_is_a_deviation(rate_range, answer):
    unit = manifest().unit.model_copy(update={"rate_range_deg_s": rate_range})
    made = content(certificate(turned(), manifest=labelled(unit=unit)))
    assert made.conditions.sentences == ()
    assert answer in made.remarks[0].text[1]
    assert made.remarks[0].text[1].startswith("Deviation: ")
    assert any("with deviations" in each[1] for each in made.statement)


def test_a_deviation_that_the_order_waives_is_printed_and_prevents_nothing():
    given = order().model_copy(update={"waived_conditions": ("largest_rate",)})
    made = content(certificate(turned(), order=given))
    assert (
        made.remarks[0].text[1].endswith("The client's order waives this condition (largest rate).")
    )
    assert any("with deviations" in each[1] for each in made.statement)


def test_a_largest_input_rate_that_was_included_about_every_axis_is_told():
    every = tuple(
        segment(axis, "rate", axis=axis, rate_deg_s=sign * 300.0)
        for axis in AXES for sign in (1, -1)
    )  # fmt: skip
    unit = manifest().unit.model_copy(update={"rate_range_deg_s": 300})
    made = content(certificate(calibration(segments=every), manifest=labelled(unit=unit)))
    assert "300 °/s; it was included about every axis" in made.conditions.sentences[0][1]
    assert not any("with deviations" in each[1] for each in made.statement)


def test_without_a_day_of_calibration_the_next_counts_from_the_certificate():
    made = {f.label[1]: f.value for f in content(certificate(calibrated_on=None)).front}
    assert made["Date of calibration"] == ("未提供", "not given")
    assert made["Recalibration due"] == (
        "2027-11-19（未提供校准日期，自证书日期起算）",
        "2027-11-19, counted from the date of issue because the date of calibration is not given",
    )


def test_an_order_received_after_the_calibration_is_refused():
    with pytest.raises(ValidationError, match=r"received = 2026-11-16, .* correct the order"):
        certificate(calibrated_on=date(2026, 11, 15))


def test_the_basis_names_only_what_was_determined_and_lists_the_rest():
    given = items()
    given["gyro_scale_factor"] = item("1", "7.2.1", AXES, [None] * 3, 1e-5)
    del given["gyro_fit_offset"]
    statement = content(certificate(calibration(items=given))).statement
    assert "7.2.1" not in statement[0][1]
    assert statement[0][0].startswith("本次校准依据 JJF 2003—2022")
    assert statement[1] == (
        "表 2 中未得出结果的项目：陀螺标度因数。",
        "Items of Table 2 not determined: Gyro scale factor.",
    )


def test_the_basis_says_what_was_taken_off_with_its_u():
    arm = FoundParameter(name="r_x", value=0.05, unit="m", u=1e-4)
    taken = AdoptedTerm(name="lever_arm", title="lever arm", title_zh="杆臂", parameters=(arm,))
    zh, en = content(certificate(calibration(terms=(taken,)))).statement[1]
    assert en.startswith(
        "Corrected in the readings beforehand: lever arm, r_x = (50.00 ± 0.20) mm (k = 2)"
    )
    assert "杆臂" in zh


def test_deviations_are_named_in_the_basis_and_on_the_cover():
    warm = Remark(code="c", en="Too warm.", zh="温度过高。", blocks_pass=True)
    made = content(certificate(calibration(remarks=(warm,))))
    assert made.statement[0][0].startswith("本次校准参照 JJF 2003—2022")
    assert "with deviations, see Remarks" in made.statement[0][1]
    specification = {f.label[1]: f.value for f in made.front}["Specification"]
    assert specification[0] == "参照 JJF 2003—2022，有偏离，见“说明”"


def test_a_verdict_on_some_elements_says_so():
    limit = Limit(item="gyro_bias", unit="deg/s", magnitude=1.0, elements=("x",))
    result = calibration()
    made = content(certificate(result, decide(result, tolerance(limits=(limit,)))))
    assert made.scope is not None
    in_part = "in 1 item only some elements have limits"
    assert made.scope[1] == f"1 of 8 items has limits and passes; {in_part}"


def test_a_fit_offset_with_a_limit_is_not_called_undecided():
    def answer(*limits: Limit) -> str:
        result = calibration()
        made = content(certificate(result, decide(result, tolerance(limits=limits))))
        return " ".join(en for _, en in made.sections[0].groups[2].sentences)

    bias = Limit(item="gyro_bias", unit="deg/s", magnitude=1.0)
    offset = Limit(item="gyro_fit_offset", unit="deg/s", magnitude=1.0)
    assert "no decision is based on it" in answer(bias)
    assert "no decision is based on it" not in answer(offset)
    assert "g_ii × 1 g and the component of Earth's rotation" in answer(offset)


def test_an_amendment_says_on_its_first_page_what_it_replaces_and_why():
    before = Replaced(number="MIMU-2026-0041", issued_on=date(2026, 11, 19), why="wrong address")
    front = content(certificate(replaces=before)).front
    (answer,) = [each.value for each in front if each.label[1] == "Replaces certificate"]
    assert answer[1] == "MIMU-2026-0041 of 2026-11-19; reason: wrong address"
    assert not [each for each in content(certificate()).front if each.label[0] == "代替证书"]


# What ISO/IEC 17025, 7.8 asks of a certificate beside clause 8 of the specification.

DCC = "{https://ptb.de/dcc}"
SET_UP = Configuration(
    rate_range_deg_s=500.0, accel_range_g=10.0, output_rate_hz=200.0, firmware="2.1",
    condition="label torn", condition_zh="标签破损",
)  # fmt: skip
LABORATORY = laboratory(
    contact=Contact(e_mail="lab@example.org", phone="+86 10 1234"),
    accreditation="CNAS L1234", place="Hall 3, Beijing", place_zh="北京三号厅",
)  # fmt: skip
MADE = certificate(
    laboratory=LABORATORY, order=order().model_copy(update={"configuration": SET_UP})
)


def front(made: Content) -> dict[str, Any]:
    return {f.label[1]: f.value[1] for f in (*made.front, *made.laboratory_fields)}


def of_object(made: Content) -> dict[str, Any]:
    return {field.label[1]: field.value[1] for field in made.calibrated_object}


def test_the_first_page_has_place_accreditation_and_contact():
    printed = front(content(MADE))
    assert printed["Place of calibration"] == "Hall 3, Beijing"
    assert printed["Accreditation"] == "CNAS L1234"
    assert printed["Contact of the laboratory"] == "+86 10 1234, lab@example.org"


def test_the_place_that_the_order_names_goes_before_the_laboratorys():
    there = order().model_copy(update={"place": "Client's hall"})
    made = certificate(laboratory=LABORATORY, order=there)
    assert front(content(made))["Place of calibration"] == "Client's hall"


def test_condition_and_configuration_are_those_of_order_and_manifest():
    unit = manifest().unit.model_copy(update={"bandwidth_hz": 80})
    given = certificate(
        order=MADE.order, manifest=manifest().model_copy(update={"unit": unit})
    )  # fmt: skip
    printed = of_object(content(given))
    assert printed | {"Adjustment": "", "Sampling": ""} == {
        "Condition": "label torn", "Range of angular rate": "±500 °/s",
        "Range of specific force": "±10 g", "Output rate": "200 Hz", "Bandwidth": "80 Hz",
        "Firmware": "2.1", "Adjustment": "", "Sampling": "",
    }  # fmt: skip


def test_whether_it_was_adjusted_or_sampled_is_always_told():
    printed = of_object(content(certificate()))
    assert printed["Adjustment"].startswith("no adjustment is recorded")
    assert printed["Sampling"].startswith("none")
    assert printed["Condition"] == printed["Range of angular rate"] == "not given"
    assert of_object(content(adjusted()))["Adjustment"].startswith("adjusted during")


@pytest.mark.parametrize(
    ("certificates", "says"),
    [
        (("A", "B"), "the certificates stated for them."),
        (("A", ""), "none is given for Thermo-hygrometer."),
        (("", ""), "no metrological traceability is claimed"),
    ],
)
def test_traceability_is_claimed_by_certificates_alone(certificates, says):
    equipment = tuple(
        standard.model_copy(update={"certificate": number})
        for standard, number in zip(laboratory().equipment, certificates, strict=True)
    )
    made = content(certificate(laboratory=laboratory(equipment=equipment)))
    assert says in made.traceability[1]


def test_no_traceability_is_claimed_for_an_invalid_run():
    invalid = calibration().model_copy(
        update={"remarks": (Remark(code="x", run="invalid", en="Invalid.", zh="无效。"),)}
    )
    made = content(certificate(calibration=invalid))
    assert made.is_report  # and has a report number
    assert not content(certificate()).is_report
    assert "no metrological traceability is claimed" in made.traceability[1]


def test_the_dcc_has_them_in_their_places_and_as_statements():
    root = etree.fromstring(faces_of(MADE, None).dcc)
    lab = root.find(f".//{DCC}calibrationLaboratory")
    assert lab.findtext(f"{DCC}calibrationLaboratoryCode") == "CNAS L1234"
    assert lab.findtext(f"{DCC}contact/{DCC}eMail") == "lab@example.org"
    assert lab.findtext(f"{DCC}contact/{DCC}phone") == "+86 10 1234"
    written = "\n".join(root.find(f".//{DCC}statements").itertext())
    for text in ("traceable to the International System", "no adjustment is recorded", "±500 °/s",
                 "label torn", "标签破损", "Hall 3, Beijing"):  # fmt: skip
        assert text in written


# A certificate with capabilities: one U in PDF, DCC and decision, and accreditation or not.

SI = "{https://ptb.de/si}"
EVERY = tuple(
    Capability(item=name, unit=ITEMS[name].unit, U=1e-9) for name in items() if name != "gyro_bias"
)
BIAS = Capability(item="gyro_bias", unit="deg/s", U=4.2e-3)  # evaluated: 3.42e-4


def made(*capabilities: Capability, **more: Any) -> Certificate:
    of = laboratory(accreditation="CNAS L1234", capabilities=capabilities)
    result = calibration()
    decision = decide(as_stated(result, of), tolerance())
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


def test_u_decided_and_printed_everywhere_is_the_capability_and_the_result_keeps_its_own():
    paper = made(*EVERY, BIAS)
    printed = content(paper)
    bias = group(printed, item_title("gyro_bias"))
    assert ({row.U for row in bias.rows}, bias.exponent) == ({"0.0042"}, 0)
    U = float(expanded_of(dcc_of(paper), "gyro_bias.x"))
    assert pytest.approx(math.radians(4.2e-3)) == U
    decided = {each.U for each in paper.decision.limits if each.item == "gyro_bias"}
    assert decided == {4.2e-3}
    assert paper.calibration.items["gyro_bias"].U["x"] == 2 * 1.71e-4
    assert b'"U":{"x":0.000342' in record_bytes(paper).replace(b" ", b"").replace(b"\n", b"")
    assert "the evaluated U is smaller, and the capability is stated" in texts(printed)


def test_a_certificate_whose_items_are_all_covered_refers_to_the_accreditation():
    printed = content(made(*EVERY, BIAS))
    assert accreditation(printed) == ["CNAS L1234"]
    assert "CNAS L1234" in dcc_of(made(*EVERY, BIAS)).decode()
    assert "outside its accreditation" not in texts(printed)


def test_an_item_that_is_not_covered_leaves_no_accreditation_on_the_certificate():
    paper = made(*EVERY)
    printed = content(paper)
    assert accreditation(printed) == []
    root = etree.fromstring(dcc_of(paper))
    assert root.find(".//{https://ptb.de/dcc}calibrationLaboratoryCode") is None
    assert "which are outside its accreditation" in texts(printed)
    assert "bias" in texts(printed).split("do not cover", 1)[1].split(", which")[0].lower()
    assert "不在认可范围内" in " ".join(sentence[0] for sentence in printed.statement)


def test_budgets_print_the_stated_u_and_say_so():
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
