"""The files that a laboratory names, as the record of a certificate holds them."""

import pytest

from schemas.base import Unusable
from schemas.certificate import Laboratory, Party
from storage.home import Home
from tasks.stages.certificate_inputs import LARGEST, with_appearance

PARTY = Party(name="L", name_zh="实", address="a", address_zh="址")


def test_files_are_counted_from_the_home_and_the_record_holds_what_is_in_them(tmp_path):
    (tmp_path / "logo.svg").write_bytes(b"<svg/>")
    (tmp_path / "own.typ").write_text("#it.number", encoding="utf-8")
    given = Laboratory(party=PARTY, logo="logo.svg", template="own.typ")
    made = with_appearance(given, Home(tmp_path))
    assert made.appearance is not None
    assert made.appearance.pictures == {"logo": b"<svg/>"}
    assert made.appearance.template == "#it.number"
    again = Laboratory.model_validate_json(made.model_dump_json())
    assert again.appearance == made.appearance
    assert again.logo is None
    assert with_appearance(again, Home(tmp_path / "elsewhere")) == again


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("logo", None, "cannot be read"),
        ("seal", bytes(LARGEST + 1), "make it smaller"),
        ("template", b"\xff\xfe", "is not UTF-8"),
    ],
)
def test_a_file_that_cannot_serve_is_one_sentence(tmp_path, name, content, fault):
    if content is not None:
        (tmp_path / "file").write_bytes(content)
    given = Laboratory.model_validate({"party": PARTY, name: "file"})
    with pytest.raises(Unusable, match=rf"^laboratory\.toml: {name} = .*{fault}"):
        with_appearance(given, Home(tmp_path))
