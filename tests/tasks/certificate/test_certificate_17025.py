"""What ISO/IEC 17025, 7.8 asks of a certificate beside clause 8 of the specification."""

from typing import Any

import pytest
from lxml import etree
from sample_certificate import calibration, certificate, content, laboratory, manifest, order
from test_certificate_as_found import adjusted

from schemas.certificate import Contact
from schemas.configuration import Configuration
from schemas.text import Remark
from tasks.certificate.content import Content
from tasks.certificate.documents import faces_of

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


def test_the_first_page_has_place_accreditation_and_contact() -> None:
    printed = front(content(MADE))
    assert printed["Place of calibration"] == "Hall 3, Beijing"
    assert printed["Accreditation"] == "CNAS L1234"
    assert printed["Contact of the laboratory"] == "+86 10 1234, lab@example.org"


def test_the_place_that_the_order_names_goes_before_the_laboratorys() -> None:
    there = order().model_copy(update={"place": "Client's hall"})
    made = certificate(laboratory=LABORATORY, order=there)
    assert front(content(made))["Place of calibration"] == "Client's hall"


def test_condition_and_configuration_are_those_of_order_and_manifest() -> None:
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


def test_whether_it_was_adjusted_or_sampled_is_always_told() -> None:
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
def test_traceability_is_claimed_by_certificates_alone(
    certificates: tuple[str, str], says: str
) -> None:
    equipment = tuple(
        standard.model_copy(update={"certificate": number})
        for standard, number in zip(laboratory().equipment, certificates, strict=True)
    )
    made = content(certificate(laboratory=laboratory(equipment=equipment)))
    assert says in made.traceability[1]


def test_no_traceability_is_claimed_for_an_invalid_run() -> None:
    invalid = calibration().model_copy(
        update={"remarks": (Remark(code="x", run="invalid", en="Invalid.", zh="无效。"),)}
    )
    made = content(certificate(calibration=invalid))
    assert made.is_report  # and has a report number
    assert not content(certificate()).is_report
    assert "no metrological traceability is claimed" in made.traceability[1]


def test_the_dcc_has_them_in_their_places_and_as_statements() -> None:
    root = etree.fromstring(faces_of(MADE, None).dcc)
    lab = root.find(f".//{DCC}calibrationLaboratory")
    assert lab.findtext(f"{DCC}calibrationLaboratoryCode") == "CNAS L1234"
    assert lab.findtext(f"{DCC}contact/{DCC}eMail") == "lab@example.org"
    assert lab.findtext(f"{DCC}contact/{DCC}phone") == "+86 10 1234"
    written = "\n".join(root.find(f".//{DCC}statements").itertext())
    for text in ("traceable to the International System", "no adjustment is recorded", "±500 °/s",
                 "label torn", "标签破损", "Hall 3, Beijing"):  # fmt: skip
        assert text in written
