"""The certificates of a unit from before a calibration: what its history is made of."""

from datetime import date

from schemas.certificate import State
from storage.catalogue import certificates, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.stages import certify
from tasks.stages.certify import earlier_certificates
from tests.drafts import calibration_of, certificate_of, recording_of
from tests.keep import keep

DAY = date(2026, 11, 20)


def kept(home: Home, recording: str, number: str, day: date, state: State = "issued") -> Run:
    """A certificate of a run of its own, of unit 1."""
    made = recording_of("1")
    manifest = made.manifest.model_copy(update={"recording_id": recording})
    run, _ = runs.add(type(made)(manifest, made.imu), home)
    paper = certificate_of(run, calibration_of(run), number=number, state=state, calibrated_on=day)
    keep(paper, home)
    return run


def test_only_issued_ones_of_other_runs_from_before_the_day_count_in_the_order_of_their_days(
    home, monkeypatch
):
    kept(home, "b", "M-2", date(2025, 11, 20))
    kept(home, "a", "M-1", date(2024, 11, 20))
    kept(home, "c", "M-C", date(2025, 5, 5), state="checked")
    kept(home, "d", "M-3", DAY)
    run = kept(home, "e", "M-0", date(2023, 11, 20))
    assert [each.number for each in earlier_certificates(run, DAY, home)] == ["M-1", "M-2"]
    assert earlier_certificates(run, None, home) == []
    monkeypatch.setattr(certify, "MOST", 1)
    assert [each.number for each in earlier_certificates(run, DAY, home)] == ["M-2"]


def test_a_record_that_was_damaged_is_passed_over(home):
    run = kept(home, "now", "M-2", DAY)
    kept(home, "then", "M-1", date(2024, 11, 20))
    (entry,) = certificates.issued_before(run, DAY, 20, home)
    (home.path / entry.record).write_text("{")
    assert earlier_certificates(run, DAY, home) == []
