"""What the client reads, and what stands in the annex for the laboratory."""

import re

import pypdfium2
import pytest

from schemas.certificate import Certificate
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.figures import curves_of_run
from tasks.certificate.pdf import render
from tasks.conformity import decide
from tasks.specifications.register import BY_STANDARD
from tests.tasks.certificate.sample_certificate import certificate

RECORDINGS = {"JJF 2003-2022": "plant_earth_rotation", "JJF 1536-2015": "ahrs_clean"}
MOST_PAGES = 6  # of the part for the client, in one language
OF_THE_LABORATORY = {
    "en": (
        "Readings of the specification", "Uncertainty budgets", "Figures", "Student's t", "λ",
        "Degrees of freedom", "degrees of freedom", "Origin and processing", "is printed",
    ),
    "zh": (
        "对规范条文的理解", "不确定度评定", "t 分布", "λ", "自由度", "数据来源与处理信息", "误作",
        "附加信息",
    ),
}  # fmt: skip


def parts(made: Certificate, language: str) -> tuple[list[str], list[str]]:
    """The pages before the annex, and those of it, by their heads."""
    heads = {"en": "Calibration Certificate · Annex", "zh": "校准证书 · 附录"}
    texts = [
        " ".join(page.get_textpage().get_text_bounded().split())
        for page in pypdfium2.PdfDocument(render(made, [language]))
    ]
    of_annex = [text.startswith(heads[language]) for text in texts]
    first = of_annex.index(True)
    assert all(of_annex[first:])
    return texts[:first], texts[first:]


@pytest.fixture(scope="module", params=list(RECORDINGS))
def made(request, plant) -> Certificate:
    recording = plant(RECORDINGS[request.param])
    result = calibrate(BY_STANDARD[request.param], recording, run="r1", code_version="test")
    curves = curves_of_run(recording, result)
    decision = decide(result, None)
    return certificate(
        result, decision, manifest=recording.manifest, curves=curves, budgets=True
    )  # fmt: skip


@pytest.mark.parametrize("language", ["en", "zh"])
def test_what_concerns_the_laboratory_alone_stands_in_the_annex(made, language):
    main, annex = parts(made, language)
    assert len(main) <= MOST_PAGES
    before = re.sub(r"An annex follows:.*|后附附录：.*", "", " ".join(main))
    assert [words for words in OF_THE_LABORATORY[language] if words in before] == []
    last = {"en": "End of certificate", "zh": "以下空白"}[language]
    assert last in annex[-1]


def test_page_numbers_go_through_both_parts(made):
    main, annex = parts(made, "en")
    pages = [*main, *annex]
    assert [f"Page {n} of {len(pages)}" in text for n, text in enumerate(pages, 1)] == [True] * len(
        pages
    )
    assert "The results relate only to the object" in main[-1]
