"""The record that ships with the code, and what the gate makes of records."""

import ast
from datetime import date

import pytest

from schemas.calibration import (
    EVIDENCE,
    Check,
    Coverage,
    ItemValidation,
    MethodValidation,
    ScenarioValidation,
    ValidationRecord,
)
from schemas.tolerance import Limit, Tolerance
from tasks.calibrate.calibrate import calibrate
from tasks.conformity import decide
from tasks.specifications.jjf2003 import JJF2003
from tasks.validation.fingerprint import (
    fingerprint,
    names_of,
    read_source,
    sources,
    text_digest,
)
from tasks.validation.record import conditions_of, doubts_of, named, shipped, validation_html
from tasks.version import code_version
from tasks.words import say, texts

METHODS = ("jjf2003", "joint", "jjf1536")


@pytest.mark.parametrize("method", METHODS)
def test_the_shipped_record_is_of_this_code(method):
    record = shipped()
    assert record is not None
    assert record.methods[method].fingerprint == fingerprint(method), (
        "the estimation was changed since the record was made: run make validate and copy the "
        "record to tasks/validation/record.json"
    )


def test_a_fingerprint_covers_what_the_numbers_come_from():
    names = {path.name for path in sources("jjf2003")}
    assert {"positions.py", "turning.py", "type_a.py", "summarise.py", "unit_model.py"} <= names
    assert "solution.py" not in names
    assert "solution.py" in {path.name for path in sources("joint")}


PLAIN = "def f(x):\n    return 2 * x\n"


@pytest.mark.parametrize("declared", [
    '"""About."""\n' + PLAIN,
    "# Why.\n\n" + PLAIN,
    'def f(x):\n    """Twice."""\n    return (2*x)',
])  # fmt: skip
def test_what_is_said_about_the_code_is_not_in_its_fingerprint(declared):
    assert read_source(declared).code == read_source(PLAIN).code


def test_a_sentence_that_numbers_are_put_into_is_not_in_the_fingerprint():
    line = 'why = message("dwell-short", seconds=f"{t:.1f}")'
    assert (
        read_source(line).code == read_source('why = message("dwell-too-short", time=str(t))').code
    )


def test_what_the_code_computes_is_in_its_fingerprint():
    assert read_source(PLAIN.replace("2", "3")).code != read_source(PLAIN).code
    assert read_source('TEXT = "about"').code != read_source('TEXT = "of"').code


def test_where_a_module_is_loaded_is_not_in_the_fingerprint_but_which_one_is():
    first = "from scipy.signal import lfilter\n\n" + PLAIN
    late = PLAIN.replace("    return", "    from scipy.signal import lfilter\n\n    return")
    assert read_source(first).code == read_source(late).code
    assert read_source(late.replace("signal", "other")).code != read_source(late).code
    assert read_source(late).code != read_source(PLAIN).code


@pytest.mark.parametrize("method", ["jjf2003", "joint", "jjf1536"])
def test_a_name_is_imported_from_one_place_within_a_file_so_where_says_nothing(method):
    for path in sources(method):
        places: dict[str, set[str]] = {}
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                for each in node.names:
                    place = f"{getattr(node, 'module', '')}.{each.name}"
                    places.setdefault(each.asname or each.name, set()).add(place)
        assert {name: found for name, found in places.items() if len(found) > 1} == {}, path


@pytest.fixture(scope="module")
def calibration(ideal_run):
    return calibrate(JJF2003, ideal_run(), run="r", code_version="v")


def record_of(calibration, print_: str, failed: str = "", missing: str = "") -> ValidationRecord:
    good = {kind: Check(passed=True, en="shown", zh="已证明") for kind in EVIDENCE}
    bad = {**good, "coverage": Check(passed=False, en="80 %", zh="80 %")}
    items = {
        name: ItemValidation(checks=bad if name == failed else good)
        for name in calibration.items
        if name != missing
    }
    return ValidationRecord(
        made_on=date(2026, 11, 21),
        code_version="0.1.0+abc numpy",
        seed=1,
        seconds=1.0,
        methods={"jjf2003": MethodValidation(fingerprint=print_, items=items)},
    )


def test_a_record_that_fits_leaves_no_doubt(calibration):
    record = record_of(calibration, fingerprint("jjf2003"))
    assert doubts_of(record, calibration) == {}
    assert "9 of 9 items" in say(named(record, calibration), "en")
    assert "2026-11-21" in say(named(record, calibration), "en")
    # The certificate names one version of the code: that by which its values were made.
    assert "0.1.0" not in say(named(record, calibration), "en")


def test_without_a_record_every_item_is_doubted_for_this_version(calibration):
    doubts = doubts_of(None, calibration)
    assert set(doubts) == set(calibration.items)
    assert all(
        "jjf2003" in text for doubt in doubts.values() for text in texts(doubt.sentence).values()
    )


def test_a_record_of_other_code_counts_as_none(calibration):
    record = record_of(calibration, "0" * 16)
    assert doubts_of(record, calibration).keys() == calibration.items.keys()
    assert say(named(record, calibration), "en").startswith("No validation record")


def test_a_record_made_by_this_very_program_is_taken_without_parsing_its_source(
    calibration, monkeypatch
):
    record = record_of(calibration, fingerprint("jjf2003"))
    made_here = record.model_copy(update={"code_version": code_version()})
    monkeypatch.setattr("tasks.validation.record.fingerprint", pytest.fail)
    assert doubts_of(made_here, calibration) == {}


def test_a_record_of_the_same_text_of_a_methods_source_is_taken_without_parsing_it(
    calibration, monkeypatch
):
    record = record_of(calibration, fingerprint("jjf2003"))
    names = names_of("jjf2003")
    kept = {"sources": names, "text": text_digest(names)}
    method = record.methods["jjf2003"].model_copy(update=kept)
    monkeypatch.setattr("tasks.validation.record.fingerprint", lambda _: "parsed")
    assert doubts_of(record.model_copy(update={"methods": {"jjf2003": method}}), calibration) == {}
    changed = method.model_copy(update={"text": text_digest(names[1:])})
    of_other = record.model_copy(update={"methods": {"jjf2003": changed}})
    assert doubts_of(of_other, calibration).keys() == calibration.items.keys()


def test_every_letter_of_a_source_and_every_file_is_in_the_hash_of_their_text(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("tasks.validation.fingerprint.ROOT", tmp_path)
    (tmp_path / "a.py").write_text("x = 1  # one\n")
    (tmp_path / "b.py").write_text("")
    before = text_digest(("a.py", "b.py"))
    assert text_digest(("a.py",)) != before
    (tmp_path / "a.py").write_text("x = 1  # two\n")
    assert text_digest(("a.py", "b.py")) != before


@pytest.mark.parametrize("how", ["failed", "missing"])
def test_one_item_that_failed_or_is_missing_is_doubted_alone(calibration, how):
    record = record_of(calibration, fingerprint("jjf2003"), **{how: "gyro_bias"})
    assert set(doubts_of(record, calibration)) == {"gyro_bias"}
    assert "8 of 9" in say(named(record, calibration), "en")


@pytest.fixture
def hidden(calibration) -> ValidationRecord:
    """A good average with an element that is not covered, and one that is covered too often."""
    shares = {"xy": 0.95, "xz": 0.911, "yx": 0.97, "yz": 0.989, "zx": 0.93, "zy": 0.951}
    cover = Coverage(
        units=2000, elements=12000, inside_95=0.95, confidence=(0.94, 0.96), inside_expanded=0.96,
        rms_z=1.0, by_element=shares,
    )  # fmt: skip
    record = record_of(calibration, fingerprint("jjf2003"))
    items = record.methods["jjf2003"].items
    checks = items["gyro_cross_coupling"].checks
    items["gyro_cross_coupling"] = ItemValidation(checks=checks, coverage=cover)
    return record


def test_an_element_that_the_average_hides_is_doubted(calibration, hidden):
    (doubt,) = doubts_of(hidden, calibration).values()
    assert doubt.elements == {"xz"}  # yz is covered too often, which is no fault
    assert "xz (91.1 %)" in say(doubt.sentence, "en")
    assert say(named(hidden, calibration), "en").endswith(
        "8 of 9 items in full; not validated: Gyro cross coupling coefficient xz"
    )
    assert '<td>xz</td><td class="number">91.1 %</td>' in validation_html(hidden)


def test_an_element_that_is_not_validated_gets_no_pass_and_the_others_do(calibration, hidden):
    limit = Limit(item="gyro_cross_coupling", unit="1", magnitude=1.0)
    tolerance = Tolerance(manufacturer="m", model="m", document="d", limits=(limit,))
    made = decide(calibration, tolerance, doubts_of=doubts_of(hidden, calibration))
    assert made.verdict == "inconclusive"
    passed = {each.element for each in made.limits if each.verdict == "pass"}
    assert passed == {"xy", "yx", "yz", "zx", "zy"}
    others = limit.model_copy(update={"elements": ("xy", "zy")})
    apart = tolerance.model_copy(update={"limits": (others,)})
    about = decide(calibration, apart, doubts_of=doubts_of(hidden, calibration))
    assert not any("not validated" in reason for reason in about.reasons)


def test_a_record_survives_being_written_and_read(calibration):
    record = record_of(calibration, "0" * 16)
    assert ValidationRecord.model_validate_json(record.model_dump_json()) == record


def test_the_page_shows_every_item_and_what_is_open(calibration):
    text = validation_html(record_of(calibration, "0" * 16, failed="gyro_bias"))
    assert all(name in text for name in calibration.items)
    assert "8 of 9 items are validated" in text
    assert "http" not in text


def test_scenarios_stand_on_the_page_and_a_certificate_names_those_of_its_run(calibration):
    cover = Coverage(
        units=200, elements=600, inside_95=0.944, confidence=(0.93, 0.96), inside_expanded=0.96,
        rms_z=1.03, by_element={"x": 0.944},
    )  # fmt: skip
    walked = ScenarioValidation(
        conditions=tuple(conditions_of(calibration)), units=200, invalid=3,
        items={"jjf2003": {"gyro_bias": cover}},
    )  # fmt: skip
    record = record_of(calibration, fingerprint("jjf2003"))
    record = record.model_copy(update={"scenarios": {"in-order": walked}})
    page = validation_html(record)
    assert '<td class="number">94.4 %</td><td class="number">1.03</td>' in page
    assert "一切正常" in page
    assert say(named(record, calibration), "en").endswith("scenarios: everything in order")
    aslant = calibration.model_copy(update={"settings": {**calibration.settings, "mount": 1.0}})
    assert say(named(record, aslant), "en").endswith(
        ", a stated mount off square) lie in none of the validated scenarios"
    )
