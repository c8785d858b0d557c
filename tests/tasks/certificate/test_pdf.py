"""The certificate as it lies on the table: every item of clause 8, nothing clipped."""

import base64
import io
import re
from datetime import date
from functools import cache
from typing import Any

import numpy as np
import pypdf
import pypdfium2
import pytest
from pydantic import ValidationError

from schemas.base import Unusable
from schemas.certificate import Certificate, Party
from schemas.laboratory import MeasurementStandard
from schemas.text import Appearance, Remark
from schemas.tolerance import Limit
from tasks.certificate.pdf import faces_of, render
from tasks.certificate.verify import verify_file
from tasks.conformity import decide
from tests.tasks.certificate.sample_certificate import (
    AXES,
    adjusted,
    bare,
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

POINT = 72 / 25.4  # points in a millimetre
SIDE_MM, TOP_MM, BOTTOM_MM = 21, 9, 9
MARKS = ("*x*", "#", "$", "@a", "<b>", "\\", '"', "'", "= h", "- l")
NASTY = r'#set text(red) *b* $x^2$ @ref <lab> `c` "q" \n [ ] { } // /* _i_ ~ -- \u{41} &amp; 惯组'


def pages(pdf: bytes) -> list[str]:
    document = pypdfium2.PdfDocument(pdf)
    return [squeezed(page.get_textpage().get_text_bounded()) for page in document]


def squeezed(text: str) -> str:
    return re.sub(r"\s+", "", text)


def boxes(page: pypdfium2.PdfPage) -> list[tuple[float, float, float, float]]:
    """(left, bottom, right, top) of every run of text, in points."""
    text = page.get_textpage()
    return [text.get_rect(n) for n in range(text.count_rects())]


def assert_nothing_is_clipped(pdf: bytes) -> None:
    for page in pypdfium2.PdfDocument(pdf):
        width, height = page.get_size()
        for left, bottom, right, top in boxes(page):
            assert left >= SIDE_MM * POINT - 1
            assert right <= width - SIDE_MM * POINT + 1
            assert bottom >= BOTTOM_MM * POINT
            assert top <= height - TOP_MM * POINT


def assert_nothing_overlaps(pdf: bytes) -> None:
    for page in pypdfium2.PdfDocument(pdf):
        runs = np.array(boxes(page))
        left, bottom, right, top = runs.T
        wide = np.minimum.outer(right, right) - np.maximum.outer(left, left)
        high = np.minimum.outer(top, top) - np.maximum.outer(bottom, bottom)
        pairs = np.argwhere(np.triu((wide >= 1.5) & (high >= 1.5), k=1))
        assert not len(pairs), (page, runs[pairs])


def failed() -> Certificate:
    bias = item("deg/s", "7.2.2", AXES, [0.2, None, -0.01], 1e-4)
    return certificate(
        calibration(
            items=items() | {"gyro_bias": bias},
            unavailable={"gyro_bias": "gyro y was not recorded"},
            unavailable_zh={"gyro_bias": "未记录 Y 轴陀螺"},
        )
    )


def stretched(text: str) -> Certificate:
    party = Party(name=text, name_zh=text, address=text, address_zh=text)
    standard = MeasurementStandard(
        name=text, name_zh=text, serial=text, accuracy=text, certificate=text
    )
    return certificate(
        laboratory=laboratory(
            party=party, equipment=(standard,), operator=text, checker=text, issuer=text,
            issuer_title=text, issuer_title_zh=text,
        ),
        order=order().model_copy(update={"client": party}),
        manifest=manifest(manufacturer=text, model=text, serial=text),
    )  # fmt: skip


@cache
def sample(*languages: str) -> bytes:
    """The sample certificate with budgets in some languages; without, in those of the house."""
    return render(with_budgets_and_limits(), languages) if languages else render(certificate())


@pytest.fixture(scope="module")
def issued() -> str:
    return "".join(pages(sample()))


@pytest.mark.parametrize(
    "words",
    [
        ("校准证书", "Calibration Certificate"),  # a
        ("示例惯性计量测试研究所", "Example Institute of Inertial Metrology"),  # b
        ("北京市海淀区学院路12号（100191）", "12 Xueyuan Road, Haidian District"),
        ("证书编号", "Certificate No.", "MIMU-2026-0042"),  # c
        ("校准专用章", "Calibration stamp"),  # d
        ("送校单位", "Client", "样例导航技术有限公司", "Sample Navigation Ltd."),  # e
        ("送校单位地址", "Address of the client", "88 Keji South Road"),
        (
            "被校对象名称",
            "Object",
            "微惯性测量组合（MIMU）",
            "Micro inertial measurement unit",
        ),  # f
        ("制造厂", "Manufacturer", "北京示例惯性科技有限公司"),
        ("型号规格", "Model", "MU-300", "编号", "Serial number", "SN-2026-00417"),
        ("接收日期", "Date of receipt", "2026-11-16"),  # g
        ("校准日期", "Date of calibration", "2026-11-19"),
        ("所用测量标准", "Measurement standards used", "三轴位置速率转台", "TT3-0417"),  # h
        ("准确度/等级", "Accuracy", "JL-2026-01873", "有效期至", "Valid until", "2027-03-14"),
        ("环境条件", "Environmental conditions", "19.6 °C … 20.9 °C", "(20 ± 5) °C"),  # i
        ("相对湿度", "Relative humidity", "41.3 % … 47.9 %", "20 % … 85 %"),
        ("校准结果", "Results of the calibration", "测量不确定度说明"),  # j
        ("Statement of uncertainty", "type A only"),
        ("签发人", "Issued by", "张伟", "职务", "Title", "技术负责人", "Technical director"),  # k
        ("签发日期", "Date of issue", "2026-11-21"),
        ("校准员", "Operator", "李明", "核验员", "Checked by", "王芳"),  # l
        ("建议复校日期", "Recalibration due", "2027-11-19"),
        ("校准依据", "Basis of the calibration", "JJF 2003—2022", "JJF 2003-2022"),
        ("符合性判定", "Statement of conformity", "Q/SL 3-2026, Table 2", "simple acceptance"),
        ("合格", "pass", "说明", "Remarks", "对规范条文的理解", "Readings of the specification"),
        (
            "数据来源与处理信息",
            "Origin and processing of the data",
            "0.1.0+4d6c767",
            "jjf2003-full",
        ),
        ("4f9c1a7e20b3d5586b1f0c9a7e64d28135fb0e9c1d27a4863e5f90b2c7d81a46",),
    ],
)
def test_every_item_of_clause_8_is_printed_in_both_languages(issued, words):
    for word in words:
        assert squeezed(word) in issued


def test_numbers_are_printed_as_they_were_rounded(issued):
    for number in ("1.00041", "0.00013", "−0.03194", "0.00683", "19.9400", "−30.0200", "10−3m"):
        assert number in issued


def test_every_page_says_which_of_how_many_it_is():
    answer = pages(sample())
    for n, text in enumerate(answer, start=1):
        assert f"第{n}页共{len(answer)}页" in text
        assert f"Page{n}of{len(answer)}" in text
        assert "MIMU-2026-0042" in text


def test_the_same_certificate_gives_the_same_bytes():
    assert render(certificate()) == sample()
    assert sample() != render(certificate(issued_on=date(2026, 11, 22)))


def test_it_is_a_pdf_a_3b_of_the_day_of_issue():
    reader = pypdf.PdfReader(io.BytesIO(sample()))
    xmp = reader.xmp_metadata
    assert xmp is not None
    assert (xmp.pdfaid_part, xmp.pdfaid_conformance) == ("3", "B")
    assert reader.metadata is not None
    assert str(reader.metadata.creation_date).startswith("2026-11-21 00:00")


def slanted(page: pypdf.PageObject) -> str:
    """What is set in italics on a page."""
    found: list[str] = []

    def note(text: str, _: object, __: object, font: dict[str, str] | None, ___: object) -> None:
        if font and "Italic" in font["/BaseFont"]:
            found.append(text)

    page.extract_text(visitor_text=note)
    return "".join(found)


@pytest.mark.rehearsal
@pytest.mark.parametrize("serial", ["T-B-X-1", f"LOT-T-B-X-{42:030d}"])
def test_letters_of_a_serial_number_are_no_symbols_of_quantities(serial):
    made = certificate()
    unit = made.manifest.unit.model_copy(update={"serial": serial})
    made = made.model_copy(update={"manifest": made.manifest.model_copy(update={"unit": unit})})
    first, *others = (slanted(page) for page in pypdf.PdfReader(io.BytesIO(render(made))).pages)
    assert "U" in "".join(others)
    assert not {"T", "B", "X"} & set(first)


def test_a_draft_is_marked_on_every_page():
    for text in pages(render(certificate(state="draft"))):
        assert "草稿" in text
        assert "DRAFT" in text


def attitude_unit() -> Certificate:
    offset = item("deg/s", "7.2", AXES, [0.001, -0.002, 0.0005], 1e-5)
    result = calibration(method="jjf1536", items={"ahrs_zero_offset": offset})
    return certificate(result, decide(result, None))


def wordy() -> Certificate:
    """A remark and a reason longer than a page, and an item of a hundred elements."""
    many = item("1", "", [f"e{n}" for n in range(100)], [0.001 * n for n in range(100)], 1e-5)
    long = "It went on and on. " * 400
    remark = Remark(code="c", en=long, zh="说来话长。" * 400, segments=("rate_x_+300",) * 80)
    result = calibration(
        method="joint", items={"odd": many}, remarks=(remark,), unavailable={"gyro_bias": long}
    )
    return certificate(result, decide(result, None))


def guarded() -> Certificate:
    """Acceptance limits and conditional verdicts in every table, of one column and of two."""
    every = items()
    limits = [
        Limit(item=name, unit=each.unit, magnitude=max(abs(v) for v in each.value.values() if v),
              rule=rule, U_max=each.U["x" if "x" in each.U else "yx"])
        for name, each in every.items()
        for rule in ("guard_band", "shared_risk")
    ]  # fmt: skip
    result = calibration(items=every)
    return certificate(result, decide(result, tolerance(limits=tuple(limits))))


def budgeted() -> Certificate:
    """With the uncertainty budgets of every item."""
    made = certificate(calibration(items=with_budgets(items())))
    return made.model_copy(update={"budgets": True})


@pytest.mark.parametrize(
    "made",
    [
        wordy,
        bare,
        *(
            pytest.param(one, marks=pytest.mark.rehearsal)
            for one in (certificate, failed, adjusted, attitude_unit, guarded, budgeted)
        ),
    ],
)
def test_nothing_is_clipped_and_nothing_overlaps(made):
    pdf = sample() if made is certificate else render(made())
    assert_nothing_is_clipped(pdf)
    assert_nothing_overlaps(pdf)


@pytest.mark.rehearsal
@pytest.mark.parametrize("text", ["长" * 180, "W" * 180, "very long name " * 14, NASTY * 2])
def test_long_texts_wrap_inside_the_page(text):
    pdf = render(stretched(text))
    assert_nothing_is_clipped(pdf)
    assert_nothing_overlaps(pdf)
    assert "".join(pages(pdf)).count(squeezed(text)) > 3


@pytest.mark.parametrize("text", [NASTY, "] [".join(MARKS)])
def test_the_users_text_comes_out_as_it_was_written(text):
    made = certificate(
        order=order().model_copy(
            update={"client": Party(name=f"[{text}]", name_zh="", address=text, address_zh="")}
        ),
        manifest=manifest(model=f"[{text}]"),
    )
    assert pages(render(made))[0].count(squeezed(f"[{text}]")) == 2


@pytest.mark.parametrize("character", ["😀", "𓀀"])
def test_a_character_without_a_glyph_is_refused_in_one_sentence(character):
    with pytest.raises(Unusable, match=r"MIMU-2026-0042 cannot be printed"):
        render(certificate(manifest=manifest(serial=f"A{character}B")))


@pytest.mark.parametrize(
    "languages",
    [("en", "zh"), *(pytest.param((one,), marks=pytest.mark.rehearsal) for one in ("zh", "en"))],
)
def test_a_certificate_is_set_in_any_languages_that_have_catalogues(languages):
    pdf = sample(*languages)
    text = "".join(pages(pdf))
    assert ("CalibrationCertificate" in text) == ("en" in languages)
    assert ("校准证书" in text) == ("zh" in languages)
    assert_nothing_is_clipped(pdf)


@pytest.mark.parametrize(
    ("usual", "ordered", "large", "absent"),
    [
        pytest.param("en", None, "CalibrationCertificate", "校准证书", marks=pytest.mark.rehearsal),
        ("en", "zh", "校准证书", "CalibrationCertificate"),
        pytest.param("zh", "both", "校准证书", None, marks=pytest.mark.rehearsal),
    ],
)
def test_the_languages_are_the_orders_else_the_laboratorys_and_verify_makes_the_same_pdf(
    tmp_path, usual, ordered, large, absent
):
    made = certificate(
        laboratory=laboratory(language=usual),
        order=order().model_copy(update={"language": ordered}),
    )
    pdf = faces_of(made, None).pdf
    text = "".join(pages(pdf))
    assert large in text
    assert absent is None or absent not in text
    file = tmp_path / "MIMU-2026-0042.pdf"
    file.write_bytes(pdf)
    assert not verify_file(file).faults


def with_budgets_and_limits() -> Certificate:
    return certificate(calibration(items=with_budgets(items())), budgets=True)


def test_no_chinese_of_the_program_is_left_in_an_english_certificate():
    party = laboratory().party.model_copy(update={"name_zh": "", "address_zh": ""})
    english = certificate(
        manifest=manifest(manufacturer="Example"),
        laboratory=laboratory(party=party, checker="Wang", issuer="Zhang"),
        operator="Li",
        budgets=True,
    )
    assert not re.findall(r"[\u4e00-\u9fff]", "".join(pages(render(english, ("en",)))))


@pytest.mark.rehearsal
@pytest.mark.parametrize("language", ["zh", "en"])
def test_the_title_leaves_room_for_the_code_and_the_last_page_is_not_next_to_empty(language):
    pdf = sample(language)
    first = pypdfium2.PdfDocument(pdf)[0]
    width, height = first.get_size()
    code = width - (SIDE_MM - 3 + 21) * POINT  # its left edge
    beside = [right for _, bottom, right, _ in boxes(first) if bottom > height - 40 * POINT]
    assert beside
    assert max(beside) < code
    origin = {"zh": "数据来源与处理信息", "en": "Originandprocessingofthedata"}
    assert origin[language] in pages(pdf)[-1]


# A unit that was adjusted: its certificate has it as found beside what it is as left.


def test_values_as_found_and_as_left_stand_in_one_row():
    section = content(adjusted()).as_found
    (bias,) = (group for group in section.groups if group.title[1] == "Gyro bias")
    _, y, _ = bias.rows
    assert (y.found, y.U_found, y.left, y.U_left) == ("−0.25140", "0.00035", "−0.03194", "0.00035")
    assert y.marks[0].words[1] == "fail"
    assert [row.marks[0].words[1] for row in bias.rows] == ["pass", "fail", "pass"]


def test_the_section_names_the_run_as_found_its_day_and_its_verdict():
    fields = {field.label[1]: field.value[1] for field in content(adjusted()).as_found.fields}
    assert fields["Run"] == "r-as-found"
    assert fields["Digest of the raw data"] == "ab" * 32
    assert fields["Date of calibration"] == "2026-11-17"
    assert fields["Verdict as found"] == "fail"


def test_verdict_is_that_as_left_and_the_cover_says_both():
    printed = content(adjusted())
    assert printed.verdict_text[1] == content(certificate()).verdict_text[1] == "pass"
    assert printed.scope[1].endswith("; as found, before it was adjusted: fail")


def test_a_limit_on_the_second_value_shows_that_value():
    """The g-sensitivity is limited less Earth's rotation, so that is what is compared."""
    made = adjusted()
    (group,) = (g for g in content(made).as_found.groups if g.title[1] == "Gyro g-sensitivity")
    assert group.quantity is not None
    value = made.calibration.items["gyro_g_sensitivity"].value_without_earth_rotation["xx"]
    assert float(group.rows[0].left) * 10**group.exponent == round(value, 5)


# What a laboratory puts on its certificates itself: logo, seal, wording, its own layout.

PICTURE = base64.b64encode(
    b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="6">'
    b'<rect width="9" height="6"/></svg>'
).decode()
OWN = '#import "parts.typ": *\n= House of gyros\n#it.number\n#fields(it.front)\n'


def of(appearance: Appearance | None = None, **changes: Any) -> Certificate:
    return certificate(laboratory=laboratory(appearance=appearance, **changes))


def text(made: Certificate, page: int = 0) -> str:
    document = pypdfium2.PdfDocument(render(made))
    return " ".join(document[page].get_textpage().get_text_bounded().split())


def test_the_seal_stands_where_the_stamp_would_be_put():
    assert "校准专用章" in text(of())
    assert "校准专用章" not in text(of(Appearance(logo=PICTURE, seal=PICTURE)))


def test_labels_are_in_the_laboratorys_words():
    words = {"conclusion": {"en": "Outcome", "zh": "结果"}}
    printed = text(of(wording=words))
    assert "Outcome" in printed
    assert "Verdict" not in printed
    with pytest.raises(Unusable, match=r"^laboratory\.toml: wording names 'verdikt'"):
        render(of(wording={"verdikt": {"en": "a", "zh": "b"}}))


def test_a_layout_of_the_laboratorys_own_takes_the_place_of_the_houses():
    printed = text(of(Appearance(template=OWN)))
    assert printed.startswith("House of gyros MIMU-2026-0042")
    assert "SN-2026-00417" in printed


@pytest.mark.parametrize(
    ("broken", "named"),
    [
        (Appearance(logo=base64.b64encode(b"no picture").decode()), "the logo of laboratory.toml"),
        (Appearance(template=OWN + "#unheard-of"), r"the template of .*unheard-of"),
        (Appearance(template='#read("/etc/passwd")'), r"the template of .*file not found"),
    ],
)
def test_what_cannot_be_set_is_one_sentence(broken, named):
    with pytest.raises(
        Unusable, match=rf"^No certificate was made: it cannot be typeset with {named}"
    ) as refused:
        render(of(broken))
    assert "\n" not in str(refused.value)


def test_a_layout_that_fetches_packages_is_refused():
    with pytest.raises(ValidationError, match="imports a package"):
        Appearance(template='#import "@preview/cetz:0.3.4": *')
