"""The Digital Calibration Certificate: valid by the published schemas, and nothing is lost."""

import base64
import math
import os
import re
from collections import Counter
from collections.abc import Iterator
from datetime import date
from decimal import Decimal
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from dcclib.validation import SchematronValidator, schematron
from lxml import etree

from schemas.certificate import Certificate, Contact, Replaced
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.figures import curves_of_run
from tasks.certificate.pdf import CertificateFiles, faces_of
from tasks.conformity import decide
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tests.tasks.certificate.sample_certificate import (
    adjusted,
    bare,
    certificate,
    laboratory,
)

SCHEMAS = Path(os.environ.get("MIMUCAL_DCC_SCHEMA", "../shared/dcc"))
SCHEMATRON = Path(schematron.__file__).parent / "schema" / "dcc.sch"
SI = "{https://ptb.de/si}"
DCC = "{https://ptb.de/dcc}"
needs_schemas = pytest.mark.skipif(not SCHEMAS.is_dir(), reason="the DCC schemas are not here")

NUMBER = re.compile(r"(?<![\w.])[−-]?\d+(?:\.\d+)?(?![\w])")
PAGE_OR_SECTION = re.compile(
    r"SHA-256|\b10[369] |第 \d+ 页 共 \d+ 页|Page \d+ of \d+|^\d+\. ", re.MULTILINE
)
EXPONENTS = (-9, -6, -3, 0, 3)  # powers of ten in which a column is printed


def of_specification(specification: type, recording: Recording) -> Certificate:
    result = calibrate(specification, recording, run="r1", code_version="0.1.0+test")
    curves = curves_of_run(recording, result)
    return certificate(result, decide(result, None), manifest=recording.manifest, curves=curves)


def amendment() -> Certificate:
    replaced = Replaced(number="MIMU-2026-0041", issued_on=date(2026, 11, 20), why="A < B & C")
    return certificate(replaces=replaced)


def full() -> Certificate:
    reached = Contact(e_mail="lab@example.org", phone="+86 10 1234", web="example.org")
    return certificate(laboratory=laboratory(contact=reached, accreditation="CNAS L1234"))


MADE = {"full": full, "adjusted": adjusted, "bare": bare, "amendment": amendment}


@pytest.fixture(scope="module", params=["2003", "1536", *MADE])
def made(request, plant) -> Certificate:
    if request.param == "2003":
        return of_specification(JJF2003, plant("plant_earth_rotation"))
    if request.param == "1536":
        return of_specification(JJF1536, plant("ahrs_clean"))
    return MADE[request.param]()


@pytest.fixture(scope="module")
def faces(made) -> CertificateFiles:
    return faces_of(made, None)


@needs_schemas
def test_the_dcc_is_valid_by_the_published_schema(faces):
    schema = etree.XMLSchema(etree.parse(SCHEMAS / "v3.3.0" / "dcc.xsd"))
    schema.assertValid(etree.fromstring(faces.dcc))


@pytest.mark.parametrize(
    "validator",
    [SchematronValidator.for_dcc, lambda: SchematronValidator.from_file(str(SCHEMATRON))],
    ids=["compiled", "source"],
)
def test_the_dcc_follows_the_rules_of_the_schematron(faces, validator):
    found = validator().validate_str(faces.dcc.decode())
    assert [each.text for each in found.failed_assertions] == []
    assert [each.text for each in found.successful_reports if each.role != "information"] == []


def test_the_record_lies_in_the_dcc_whole(faces, made):
    (data,) = etree.fromstring(faces.dcc).iter(f"{DCC}dataBase64")
    assert base64.b64decode(data.text) == faces.record
    assert Certificate.model_validate_json(faces.record) == made


def test_every_number_of_the_printed_pages_stands_in_the_dcc(faces):
    printed = numbers(PAGE_OR_SECTION.sub(" ", pages(faces.pdf)))
    assert printed
    assert printed - numbers_of_dcc(faces.dcc) == set()


def test_every_result_of_the_dcc_is_printed_with_its_uncertainty(faces):
    printed = numbers(pages(faces.pdf))
    for label, value, U, _ in results(faces.dcc):
        ways = [(written(value, e), written(U, e)) for e in EXPONENTS]
        assert any({v, u} - {""} <= printed for v, u in ways), (label, value, U)


def test_every_result_of_the_dcc_is_that_of_the_record_to_its_last_place(faces):
    record = Certificate.model_validate_json(faces.record)
    sources = [record.calibration, *([record.as_found.calibration] if record.as_found else [])]
    observed = set()
    for label, value, U, k in results(faces.dcc):
        name, *which, element = label.split(".")
        field = which[0] if which else "value"
        of_results = [{**source.items, **source.information}[name] for source in sources]
        half_place = Decimal((0, (5,), int(value.as_tuple().exponent) - 1))
        nearest = min(abs(Decimal(repr(getattr(i, field)[element])) - value) for i in of_results)
        assert nearest <= half_place
        if U is not None:
            own = field.replace("value", "U", 1)
            largest = [(getattr(i, own, None) or i.U)[element] for i in of_results]
            assert min(abs(float(U) / each - 1) for each in largest) < 0.1
            assert k in {Decimal(f"{i.k:g}") for i in of_results}
        observed.add((name, element))
    determined = {
        (name, element)
        for name, item in record.calibration.items.items()
        for element, value in item.value.items()
        if value is not None
    }
    assert determined <= observed


@pytest.mark.parametrize("made", ["2003", "1536"], indirect=True)
def test_every_point_of_a_curve_stands_in_the_dcc_as_in_the_record(made, faces):
    record = Certificate.model_validate_json(faces.record)
    figures = [
        result
        for result in etree.fromstring(faces.dcc).iter(f"{DCC}result")
        if "mimucal_curve" in str(result.get("refType")).split()
    ]
    listed, expanded = (
        [
            [float(number) for number in element.text.split()]
            for figure in figures
            for element in figure.iter(f"{SI}{name}")
        ]
        for name in ("valueXMLList", "valueExpandedMUXMLList")
    )
    assert len(record.curves) >= 6
    in_si = {"deg/s": math.pi / 180, "deg/h": math.pi / 648e3, "m/s2": 1.0, "s": 1.0, "1": 1.0}
    for n, curve in enumerate(record.curves):
        x, y = in_si[curve.x_unit], in_si[curve.y_unit]
        assert listed[2 * n] == pytest.approx([x * each for each in curve.x])
        assert listed[2 * n + 1] == pytest.approx([y * each for each in curve.y])
        assert expanded[n] == pytest.approx([y * each for each in curve.U])


@pytest.mark.parametrize("made", ["2003", "1536"], indirect=True)
def test_the_covariance_of_all_elements_stands_in_the_dcc_in_si_units(made, faces):
    covariance = made.calibration.covariance
    assert covariance is not None
    (result,) = (
        each
        for each in etree.fromstring(faces.dcc).iter(f"{DCC}result")
        if each.get("refType") == "mimucal_covariance"
    )
    labels = [each.text for each in result.iter(f"{SI}label")]
    assert tuple(labels) == covariance.elements
    gravity = made.manifest.station.gravity_m_s2
    degree = math.pi / 180
    factors, powers = [], []
    in_si = {"1": (1.0, ""), "deg": (degree, "radian"), "deg/s": (degree, "radian second-1"),
             "(deg/s)/g": (degree / gravity, "radian second metre-1"), "m": (1.0, "metre"),
             "m/s2": (1.0, "metre second-2")}  # fmt: skip
    for label in labels:
        factor, unit = in_si[made.calibration.items[label.split(".")[0]].unit]
        factors.append(factor)
        powers.append(base_units(unit))
    columns = list(result.iter(f"{SI}column"))
    matrix = np.array([[float(n.text) for n in each.iter(f"{SI}value")] for each in columns])
    expected = np.zeros((len(labels), len(labels)))
    expected[np.tril_indices(len(labels))] = [c for row in covariance.rows for c in row]
    expected += np.tril(expected, -1).T
    np.testing.assert_allclose(matrix, expected * np.outer(factors, factors), rtol=1e-8)
    assert np.linalg.eigvalsh(matrix / np.sqrt(np.outer(np.diag(matrix), np.diag(matrix))))[0] > 0
    for j, column in enumerate(columns):
        units = [each.text for each in column.iter(f"{SI}unit")]
        for unit, power in zip(units, powers, strict=True):
            spaced = re.sub(r"\\tothe\{([^}]*)\}", r"\1", unit).replace("\\", " ").strip()
            both = {name: power[name] + powers[j][name] for name in (*power, *powers[j])}
            assert base_units(spaced) == {name: p for name, p in both.items() if p}
    # χ² of 12 and 42 degrees of freedom at 95 %, from printed tables.
    k = float(result.findtext(f".//{SI}coverageFactor"))
    assert k**2 == pytest.approx({12: 21.026, 42: 58.124}[len(labels)], rel=1e-3)


def test_a_rate_is_given_in_radians_too_and_a_ratio_once():
    root = etree.fromstring(faces_of(certificate(), None).dcc)
    by_label = {}
    for real in root.iter(f"{SI}real"):
        by_label.setdefault(real.findtext(f"{SI}label"), []).append(real)
    in_si, in_degrees = by_label["gyro_bias.x"]
    assert in_si.findtext(f"{SI}unit") == r"\radian\second\tothe{-1}"
    assert float(in_si.findtext(f"{SI}value")) == pytest.approx(0.01187 * 3.14159265 / 180, 1e-8)
    assert in_degrees.findtext(f"{SI}value") == "0.01187"
    (ratio,) = by_label["gyro_scale_factor.x"]
    assert ratio.findtext(f"{SI}unit") == r"\one"
    per_g, _ = by_label["gyro_g_sensitivity.xx"]
    expected = 0.00951 * 3.14159265 / 180 / 9.8015
    assert float(per_g.findtext(f"{SI}value")) == pytest.approx(expected, 1e-8)


def test_limits_and_verdicts_stand_beside_their_elements():
    root = etree.fromstring(faces_of(certificate(), None).dcc)
    decided = {
        quantity.findtext(f".//{SI}label"): quantity.findtext(f".//{DCC}conformity")
        for quantity in root.iter(f"{DCC}quantity")
        if quantity.find(f"{DCC}measurementMetaData") is not None
    }
    expected = {
        ".".join(filter(None, (
            limit.item, limit.applied_to if limit.applied_to != "value" else "", limit.element
        ))): "conditionalPass" if limit.marginal and limit.verdict == "pass" else limit.verdict
        for limit in certificate().decision.limits
    }  # fmt: skip
    assert decided == expected


def test_a_text_that_is_markup_or_has_control_characters_stays_a_text():
    party = laboratory().party.model_copy(update={"name": "<a>&b;\x00\x0b ]]>"})
    root = etree.fromstring(faces_of(certificate(laboratory=laboratory(party=party)), None).dcc)
    name = root.find(f".//{DCC}calibrationLaboratory/{DCC}contact/{DCC}name")
    assert name is not None
    assert name[1].text == "<a>&b; ]]>"


def base_units(text: str) -> Counter[str]:
    """Powers of base units in a text such as "radian second-1"; none of a ratio."""
    found = (re.fullmatch(r"([a-z]+)([-\d.]*)", each) for each in text.split())
    return Counter({m[1]: float(m[2] or 1) for m in found if m and m[1] != "one"})


def pages(pdf: bytes) -> str:
    document = pypdfium2.PdfDocument(pdf)
    return "\n".join(page.get_textpage().get_text_bounded() for page in document)


def numbers(text: str) -> set[str]:
    return {number.replace("-", "−") for number in NUMBER.findall(text)}


def written(number: Decimal | None, exponent: int) -> str:
    return "" if number is None else format(number.scaleb(-exponent), "f").replace("-", "−")


def numbers_of_dcc(dcc: bytes) -> set[str]:
    """Numbers of its texts and of its quantities, without the attached record."""
    root = etree.fromstring(dcc)
    found = set()
    for element in root.iter():
        if element.tag in (f"{SI}value", f"{SI}valueExpandedMU"):
            found |= {written(Decimal(element.text), exponent) for exponent in EXPONENTS}
        elif element.tag != f"{DCC}dataBase64":
            found |= numbers(element.text or "")
    return found


def results(dcc: bytes) -> Iterator[tuple[str, Decimal, Decimal | None, Decimal | None]]:
    """(label, value, U, k) of every result, in the unit in which it is printed: the last."""
    for quantity in etree.fromstring(dcc).iter(f"{DCC}quantity"):
        if quantity.find(f"{SI}list") is not None:
            continue  # all of them again, unrounded, with their covariance
        labelled = [r for r in quantity.iter(f"{SI}real") if r.find(f"{SI}label") is not None]
        if labelled:
            texts = [
                labelled[-1].findtext(f".//{SI}{name}")
                for name in ("label", "value", "valueExpandedMU", "coverageFactor")
            ]
            value, U, k = (None if text is None else Decimal(text) for text in texts[1:])
            assert value is not None
            yield str(texts[0]), value, U, k
