"""Files that the laboratory writes: read as they are meant, refused with one sentence."""

from pathlib import Path

import pytest

from schemas.base import Unusable
from schemas.certificate import Laboratory
from schemas.tolerance import Tolerance
from storage import settings

TOLERANCE = """
format = "mimu-tolerance/1"
manufacturer = "Maker"
model = "U 1"
document = "data sheet, edition 3"
limits = [{item = "gyro_bias", unit = "deg/s", lower = -0.1, upper = 0.1}]
"""

PARTY = '{name = "Lab", name_zh = "实验室", address = "Street 1", address_zh = "街1号"}'


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_tolerance_is_read_from_toml_and_from_json(tmp_path):
    tolerance = settings.read(write(tmp_path / "limits.toml", TOLERANCE), Tolerance)
    assert tolerance.limits[0].upper == 0.1
    json = write(tmp_path / "limits.json", "\ufeff" + tolerance.model_dump_json())
    assert settings.read(json, Tolerance) == tolerance


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        ("a.toml", lambda text: text.replace("0.1}", '"wide"}'), r"limits\.0\.upper: .*'wide'"),
        ("a.toml", lambda text: text.replace("document", "documnt"), r"document is missing"),
        ("a.toml", lambda text: text + "colour = 1\n", r"colour: Extra inputs"),
        ("a.toml", lambda text: text.replace("0.1}", "-0.5}"), r"lower ≥ upper"),
        ("a.toml", lambda text: text.replace("/1", "/9"), r"format: .*mimu-tolerance/9"),
        ("a.toml", lambda text: text.replace("]", ""), r"is not TOML"),
        ("a.json", lambda text: text, r"is not JSON"),
        ("a.json", lambda text: "[" * 100_000, r"is not JSON"),
        ("a.json", lambda text: "[]", r"document: .*\[\]"),
        ("a.txt", lambda text: text, r"neither \.toml nor \.json"),
    ],
)
def test_bad_file_is_one_sentence_naming_file_field_and_value(tmp_path, name, change, says):
    path = write(tmp_path / name, change(TOLERANCE))
    with pytest.raises(Unusable, match=says) as caught:
        settings.read(path, Tolerance)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_file_that_is_missing_or_not_text_is_one_sentence(tmp_path):
    with pytest.raises(Unusable, match=r"none\.toml cannot be read"):
        settings.read(tmp_path / "none.toml", Tolerance)
    (tmp_path / "bytes.toml").write_bytes(b"a = '\xff'")
    with pytest.raises(Unusable, match="is not UTF-8"):
        settings.read(tmp_path / "bytes.toml", Tolerance)


def test_limits_of_a_model_are_found_whatever_the_file_is_called(fresh):
    assert settings.tolerance_for("Maker", "U 1", fresh) is None
    write(fresh.tolerances / "any name.toml", TOLERANCE)
    write(fresh.tolerances / "other.toml", TOLERANCE.replace("U 1", "U 2"))
    write(fresh.tolerances / "notes.txt", "not limits")
    for name in ("U 1", "u  1", " U 1"):
        tolerance = settings.tolerance_for("MAKER", name, fresh)
        assert tolerance is not None
        assert tolerance.model == "U 1"
    assert settings.tolerance_for("Maker", "U 3", fresh) is None


def test_two_files_for_one_model_are_refused(fresh):
    for name in ("a.toml", "b.toml"):
        write(fresh.tolerances / name, TOLERANCE)
    with pytest.raises(Unusable, match=r"a\.toml and .*b\.toml both hold limits of Maker U 1"):
        settings.tolerance_for("Maker", "U 1", fresh)


def test_file_that_cannot_be_read_is_not_passed_over(fresh):
    write(fresh.tolerances / "a.toml", TOLERANCE)
    write(fresh.tolerances / "b.toml", "model = ")
    with pytest.raises(Unusable, match=r"b\.toml is not TOML"):
        settings.tolerance_for("Maker", "U 1", fresh)


def test_a_laboratory_tells_its_own_limits_by_name(fresh):
    path = fresh.path / "laboratory.toml"
    own = '[limits.rate]\nhalf_width = 2e-6\ndistribution = "normal"\nsource = "certificate 7"\n'
    laboratory = settings.read(write(path, f"party = {PARTY}\n{own}"), Laboratory)
    assert laboratory.limits["rate"].half_width == 2e-6
    write(path, f"party = {PARTY}\n{own.replace('limits.rate', 'limits.colour')}")
    with pytest.raises(Unusable, match=r"limits\.colour"):
        settings.read(path, Laboratory)
    write(path, f"party = {PARTY}\n{own.replace('2e-6', '-2e-6')}")
    with pytest.raises(Unusable, match=r"limits\.rate\.half_width"):
        settings.read(path, Laboratory)
