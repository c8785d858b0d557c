"""What a laboratory puts on its certificates itself: logo, seal, wording, its own layout."""

import base64
from typing import Any

import pypdfium2
import pytest
from pydantic import ValidationError
from sample_certificate import certificate, laboratory

from schemas.appearance import Appearance
from schemas.base import Unusable
from schemas.certificate import Certificate
from tasks.certificate.pdf import render

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


def test_the_seal_stands_where_the_stamp_would_be_put() -> None:
    assert "校准专用章" in text(of())
    assert "校准专用章" not in text(of(Appearance(logo=PICTURE, seal=PICTURE)))


def test_labels_are_in_the_laboratorys_words() -> None:
    words = {"conclusion": {"en": "Outcome", "zh": "结果"}}
    printed = text(of(wording=words))
    assert "Outcome" in printed
    assert "Verdict" not in printed
    with pytest.raises(Unusable, match=r"^laboratory\.toml: wording names 'verdikt'"):
        render(of(wording={"verdikt": {"en": "a", "zh": "b"}}))


def test_a_layout_of_the_laboratorys_own_takes_the_place_of_the_houses() -> None:
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
def test_what_cannot_be_set_is_one_sentence(broken: Appearance, named: str) -> None:
    with pytest.raises(
        Unusable, match=rf"^No certificate was made: it cannot be typeset with {named}"
    ) as refused:
        render(of(broken))
    assert "\n" not in str(refused.value)


def test_a_layout_that_fetches_packages_is_refused() -> None:
    with pytest.raises(ValidationError, match="imports a package"):
        Appearance(template='#import "@preview/cetz:0.3.4": *')
