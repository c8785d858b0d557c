"""Certificates: numbered once, never changed, and when their units come back."""

from collections.abc import Callable
from datetime import date

import pytest

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Certificate
from schemas.recording import Recording
from storage.catalogue import certificates, listing, results, runs
from storage.home import Home

Build = Callable[..., Recording]
Calibrate = Callable[..., Calibration]
Certify = Callable[..., Certificate]
Issue = Callable[..., Certificate]

PDF = b"%PDF made up"


@pytest.fixture
def issue(fresh: Home, small: Build, calibrated: Calibrate, certified: Certify) -> Issue:
    """Keeps a certificate of a unit and gives it."""

    def keep(number: str, serial: str = "1", supersedes: str | None = None, **changes: object):
        recording = small(serial=serial)
        calibration = calibrated(runs.add(recording, fresh)[0])
        certificate = certified(recording, calibration, number, **changes)
        why = "an error" if supersedes else None
        certificates.save(certificate, PDF, fresh, supersedes=supersedes, why=why)
        return certificate

    return keep


def test_numbers_count_up_for_each_prefix_and_year(fresh: Home) -> None:
    asked = [("MIMU", 2026), ("MIMU", 2026), ("LAB", 2026), ("MIMU", 2027), ("MIMU", 2026)]
    assert [certificates.reserve_number(fresh, *one) for one in asked] == [
        "MIMU-2026-0001",
        "MIMU-2026-0002",
        "LAB-2026-0001",
        "MIMU-2027-0001",
        "MIMU-2026-0003",
    ]


def test_numbers_reserved_at_once_are_never_the_same(
    fresh: Home, at_once: Callable[..., list[str]]
) -> None:
    script = "print(*[certificates.reserve_number(home, 'MIMU', 2026) for _ in range(25)])"
    numbers = " ".join(at_once(script, fresh, processes=3)).split()
    assert sorted(numbers) == [f"MIMU-2026-{n:04d}" for n in range(1, 76)]


@pytest.mark.parametrize("prefix", ["", "../x", "a/b", ".hidden", "a b"])
def test_prefix_that_is_no_file_name_is_refused(fresh: Home, prefix: str) -> None:
    with pytest.raises(Unusable, match="certificate_prefix"):
        certificates.reserve_number(fresh, prefix, 2026)


def test_certificate_comes_back_as_it_went_in(fresh: Home, issue: Issue) -> None:
    certificate = issue("A-1")
    assert certificates.find("A-1", fresh) == certificate
    (entry,) = certificates.register(fresh)
    assert (fresh.path / entry.pdf).read_bytes() == PDF
    assert (entry.number, entry.verdict, entry.due) == ("A-1", "pass", date(2027, 11, 21))
    assert entry.result == results.of_run(listing.find(entry.run, fresh), fresh)[0].id


def test_same_certificate_again_changes_nothing(fresh: Home, issue: Issue) -> None:
    issue("A-1")
    issue("A-1")
    assert len(certificates.register(fresh)) == 1


def test_other_content_under_a_taken_number_is_refused(fresh: Home, issue: Issue) -> None:
    certificate = issue("A-1")
    with pytest.raises(Unusable, match="never overwritten"):
        issue("A-1", issued_on=date(2026, 12, 1))
    assert certificates.find("A-1", fresh) == certificate


def test_certificate_points_to_the_result_that_it_prints(
    fresh: Home, small: Build, calibrated: Calibrate, certified: Certify
) -> None:
    recording = small()
    run = runs.add(recording, fresh)[0]
    one = results.save(calibrated(run), fresh)
    results.save(calibrated(run, 0.5), fresh)
    certificates.save(certified(recording, calibrated(run), "A-1"), PDF, fresh)
    assert certificates.register(fresh)[0].result == one
    assert len(results.of_run(run, fresh)) == 2


def test_unknown_certificate_is_one_sentence(fresh: Home) -> None:
    with pytest.raises(Unusable, match="There is no certificate 'A-1'"):
        certificates.find("A-1", fresh)


def test_certificate_is_superseded_once_and_with_a_reason(
    fresh: Home, issue: Issue, small: Build, calibrated: Calibrate, certified: Certify
) -> None:
    issue("A-1")
    issue("A-2", supersedes="A-1", state="amended")
    assert certificates.register(fresh)[1].supersedes == "A-1"
    with pytest.raises(Unusable, match="already superseded by A-2"):
        issue("A-3", supersedes="A-1")
    with pytest.raises(Unusable, match="no certificate 'A-9' to supersede"):
        issue("A-3", supersedes="A-9")
    recording = small()
    third = certified(recording, calibrated(runs.add(recording, fresh)[0]), "A-3")
    with pytest.raises(Unusable, match="say why"):
        certificates.save(third, PDF, fresh, supersedes="A-2")
    assert not (fresh.certificates / "A-3.pdf").exists()


def test_units_are_due_by_their_newest_certificate_the_longest_overdue_first(
    fresh: Home, issue: Issue
) -> None:
    issue("A-1", "1", calibrated_on=date(2025, 1, 5), due=date(2026, 1, 5))
    issue("A-2", "1", calibrated_on=date(2026, 1, 4), due=date(2027, 1, 4), state="draft")
    issue("B-1", "2", calibrated_on=date(2025, 3, 1), due=date(2026, 3, 1))
    issue("C-1", "3", calibrated_on=date(2026, 6, 1), due=date(2027, 6, 1))
    found = certificates.due(fresh, date(2027, 1, 4))
    assert [line.model_dump() for line in found] == [
        {"unit": "Maker U 2", "certificate": "B-1", "due": date(2026, 3, 1), "state": "issued"},
        {"unit": "Maker U 1", "certificate": "A-2", "due": date(2027, 1, 4), "state": "draft"},
    ]
    assert [line.certificate for line in certificates.due(fresh, date(2027, 1, 3))] == ["B-1"]


def test_amended_certificate_replaces_and_withdrawn_one_removes_the_date(
    fresh: Home, issue: Issue
) -> None:
    issue("A-1", due=date(2027, 1, 1))
    issue("A-2", supersedes="A-1", state="amended", due=date(2027, 2, 1))
    assert [line.certificate for line in certificates.due(fresh, date(2030, 1, 1))] == ["A-2"]
    issue("A-3", supersedes="A-2", state="withdrawn")
    assert certificates.due(fresh, date(2030, 1, 1)) == []
