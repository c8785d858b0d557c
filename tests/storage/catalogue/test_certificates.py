"""Certificates in the register: numbered once, files whole, and when their units come back."""

from collections.abc import Callable
from datetime import date

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from schemas.certificate import Certificate, Replaced
from schemas.recording import Recording
from schemas.text import Remark
from storage.catalogue import certificates, database, results, runs, tables
from storage.catalogue.run_states import complete_certificates
from storage.home import Home
from tests.drafts import draft
from tests.keep import keep, take_number
from tests.storage.small import calibrated, certified, small

Keep = Callable[..., Certificate]

PDF = b"%PDF made up"


@pytest.fixture
def kept(fresh) -> Keep:
    """Keeps a certificate of a unit and gives it."""

    def build(number: str, serial: str = "1", **changes: object) -> Certificate:
        recording = small(serial=serial)
        calibration = calibrated(runs.add(recording, fresh)[0])
        certificate = certified(recording, calibration, number, **changes)
        keep(certificate, fresh, PDF)
        return certificate

    return build


def test_numbers_count_up_for_each_prefix_and_year(fresh):
    asked = [("MIMU", 2026), ("MIMU", 2026), ("LAB", 2026), ("MIMU", 2027), ("MIMU", 2026)]
    assert [take_number(fresh, *one) for one in asked] == [
        "MIMU-2026-0001",
        "MIMU-2026-0002",
        "LAB-2026-0001",
        "MIMU-2027-0001",
        "MIMU-2026-0003",
    ]


@pytest.mark.parametrize(
    ("scheme", "expected"),
    [
        ("{prefix}-{year}-{serial:04d}", ["L-2026-0001", "L-2026-0002", "L-2027-0001"]),
        ("{prefix}{serial}", ["L1", "L2", "L3"]),
    ],
)
def test_a_scheme_without_the_year_goes_on_counting(fresh, scheme, expected):
    with database.changing(fresh) as connection:
        given = [
            certificates.next_number(connection, certificates.series_of(scheme, "L", year))
            for year in (2026, 2026, 2027)
        ]
    assert given == expected


def test_numbers_taken_at_once_are_never_the_same(either, at_once):
    script = "from tests.keep import take_number\nprint(*[take_number(home) for _ in range(25)])"
    given = " ".join(at_once(script, either, processes=3, has_catalogue=False)).split()
    assert sorted(given) == [f"MIMU-2026-{n:04d}" for n in range(1, 76)]


def test_certificate_comes_back_as_it_went_in(fresh, kept):
    certificate = kept("A-1")
    assert certificates.find("A-1", fresh) == certificate
    (entry,) = certificates.register(fresh)
    assert (fresh.path / entry.pdf).read_bytes() == PDF
    assert (entry.number, entry.verdict, entry.due) == ("A-1", "pass", date(2027, 11, 21))
    assert entry.result == results.of_run(runs.find(entry.run, fresh), fresh)[0].id


def test_a_number_that_is_taken_is_refused_and_its_files_stay(fresh, kept):
    certificate = kept("A-1")
    with pytest.raises(Unusable, match="A-1 is already in the register"):
        kept("A-1", issued_on=date(2026, 12, 1))
    assert certificates.find("A-1", fresh) == certificate


def test_files_left_under_a_number_that_was_never_given_are_replaced(fresh, kept):
    fresh.certificates.mkdir(parents=True)
    left = fresh.certificates / "A-1.pdf"
    left.write_bytes(b"of an issue that was killed")
    left.chmod(0o444)
    kept("A-1")
    assert left.read_bytes() == PDF


@pytest.mark.parametrize("number", ["", "../x", "a/b", ".hidden", "a b"])
def test_a_number_that_is_no_file_name_is_refused(fresh, kept, number):
    with pytest.raises(Unusable, match="becomes a file name"):
        kept(number)


def test_versions_of_a_draft_have_files_of_their_own(fresh, kept):
    draft = kept("draft-1", state="draft")
    (one,) = certificates.register(fresh)
    with database.changing(fresh) as connection:
        certificates.remove(connection, one)
    kept("draft-1", state="draft", budgets=True)
    (other,) = certificates.register(fresh)
    assert not one.files.keys() & other.files.keys()
    certificates.remove_files([one], [], fresh)
    assert not any((fresh.path / name).exists() for name in one.files)
    assert certificates.find("draft-1", fresh) != draft


def test_keys_of_drafts_are_free_ones(fresh, kept):
    run = runs.add(kept("draft-r1234567", state="draft") and _recording(fresh), fresh)[0].id
    with database.changing(fresh) as connection:
        assert certificates.free_key(connection, "r1234567abcd") == "draft-r1234567-2"
        assert certificates.free_key(connection, run) == f"draft-{run[:8]}"


def _recording(home: Home) -> Recording:
    return runs.load(runs.all_runs(home)[0], home)


def test_certificate_points_to_the_result_that_it_prints(fresh):
    recording = small()
    run = runs.add(recording, fresh)[0]
    one = results.save(calibrated(run), fresh)
    results.save(calibrated(run, 0.5), fresh)
    keep(certified(recording, calibrated(run), "A-1"), fresh)
    assert certificates.register(fresh)[0].result == one
    assert len(results.of_run(run, fresh)) == 2


def test_unknown_certificate_is_one_sentence(fresh):
    with pytest.raises(Unusable, match="There is no certificate 'A-1'"):
        certificates.find("A-1", fresh)


def test_an_amendment_names_what_it_replaces(fresh, kept):
    kept("A-1")
    kept("A-2", replaces=Replaced(number="A-1", issued_on=date(2026, 11, 22), why="an address"))
    entry = certificates.register(fresh)[1]
    assert (entry.supersedes, entry.why) == ("A-1", "an address")


def test_units_are_due_by_their_newest_issued_certificate_the_longest_overdue_first(fresh, kept):
    kept("A-1", "1", calibrated_on=date(2025, 1, 5), due=date(2026, 1, 5))
    kept("A-2", "1", calibrated_on=date(2026, 1, 4), due=date(2027, 1, 4))
    kept("B-1", "2", calibrated_on=date(2025, 3, 1), due=date(2026, 3, 1))
    kept("C-1", "3", calibrated_on=date(2026, 6, 1), due=date(2027, 6, 1))
    kept("E-1", "4", calibrated_on=date(2025, 6, 1), due=None)
    found = certificates.due(fresh, date(2027, 1, 4))
    assert [(line.unit, line.model, line.certificate, line.due) for line in found] == [
        ("Maker U 2", "U", "B-1", date(2026, 3, 1)),
        ("Maker U 1", "U", "A-2", date(2027, 1, 4)),
    ]
    assert [line.certificate for line in certificates.due(fresh, date(2027, 1, 3))] == ["B-1"]


def test_neither_drafts_nor_what_was_amended_or_withdrawn_has_a_due_date(fresh, kept):
    for number, state in (("D-1", "draft"), ("D-2", "checked"), ("A-1", "issued")):
        kept(number, state=state, due=date(2027, 1, 1))
    ever = date(2030, 1, 1)
    assert [line.certificate for line in certificates.due(fresh, ever)] == ["A-1"]
    for state in ("amended", "withdrawn"):
        with database.changing(fresh) as connection:
            certificates.change_state(connection, "A-1", state)
        assert certificates.due(fresh, ever) == []


def test_the_report_of_an_invalid_run_leaves_the_certificate_before_it_the_newest(fresh, kept):
    valid = kept("A-1", calibrated_on=date(2025, 1, 5), due=date(2026, 1, 5))
    wrong = Remark(code="clocks_apart", en="Two clocks.", zh="两个时钟。", run="invalid")
    invalid = valid.calibration.model_copy(update={"remarks": (wrong,)})
    later = {"number": "A-2", "calibrated_on": date(2025, 6, 1), "due": None}
    keep(valid.model_copy(update={"calibration": invalid, **later}), fresh, PDF)
    assert [line.certificate for line in certificates.due(fresh, date(2027, 1, 1))] == ["A-1"]


# What an earlier version kept gets the rows that certificates have today.


def decisions(home: Home) -> list[tuple]:
    return [tuple(row) for row in database.rows(home, sql.select(tables.decisions))]


def test_what_a_certificate_decides_is_kept_with_it_and_filled_in_from_its_record(tmp_path):
    home = Home(tmp_path)
    draft(home, "1")
    kept = decisions(home)
    (row,) = kept
    assert row[2:] == ("gyro_bias", "x", "value", -1.0, 1.0, "pass")
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        connection.execute(sql.update(tables.certificates).values(limits=None))
    complete_certificates(home)
    assert decisions(home) == kept
    draft(home, "1")  # in the place of the one before
    assert len(decisions(home)) == 1


def test_a_record_that_cannot_be_read_is_left_out(tmp_path):
    home = Home(tmp_path)
    draft(home, "1")
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        connection.execute(sql.update(tables.certificates).values(limits=None, record="none"))
    complete_certificates(home)
    assert decisions(home) == []
