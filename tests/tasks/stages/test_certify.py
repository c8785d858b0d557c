"""A certificate's inputs and dates: what is refused leaves no draft, and no day is invented."""

import json
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from functools import cache
from typing import Any

import pytest

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Laboratory, Order, Party
from schemas.recording import Recording
from schemas.text import Remark
from schemas.tolerance import Capability, Limit, Tolerance
from storage.catalogue import certificates, results, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.certificate import pdf
from tasks.certificate.pdf import render
from tasks.stages.certificate_inputs import CertificateInputs as Inputs
from tasks.stages.certify import certify, due_date
from tasks.stages.estimate import estimate
from tasks.validation import record
from tasks.validation.fingerprint import fingerprint
from tests.keep import keep

pytestmark = pytest.mark.usefixtures("unprinted")

PARTY = Party(name="L", name_zh="实", address="a", address_zh="址")
STANDARD = {"name": "Table", "name_zh": "台", "serial": "1", "accuracy": "1″", "certificate": "C",
            "valid_until": "2026-03-31"}  # fmt: skip
Given = tuple[Run, Calibration, Home]
Keep = Callable[..., Given]


@pytest.fixture(scope="module")
def estimated(ideal_run, tmp_path_factory) -> Callable[[str], tuple[Recording, Calibration]]:
    """An ideal run whose manifest says what is given beside, in JSON, and its result."""

    @cache
    def build(statement: str) -> tuple[Recording, Calibration]:
        made = ideal_run(dwell=1.0)
        fields = made.manifest.model_dump() | json.loads(statement)
        recording = replace(made, manifest=made.manifest.model_validate(fields))
        home = Home(tmp_path_factory.mktemp("estimated"))
        run, _ = runs.add(recording, home)
        return recording, estimate(run, home)

    return build


@pytest.fixture
def kept(estimated, tmp_path, monkeypatch) -> Keep:
    """Keeps such a run and its result in a home of the test's own."""
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    home = Home(tmp_path / "home")

    def build(**statement: Any) -> Given:
        recording, calibration = estimated(json.dumps(statement, sort_keys=True))
        run, _ = runs.add(recording, home)
        assert run.id == calibration.run
        results.save(calibration, home)
        return run, calibration, home

    return build


def tolerance(**changes: Any) -> Tolerance:
    limit = Limit(item="gyro_scale_factor", unit="1", lower=0.9, upper=1.1)
    given = {"manufacturer": "test", "model": "ideal", "document": "d", "limits": (limit,)}
    return Tolerance(**(given | changes))


def order(received: date, **more: Any) -> Order:
    return Order(client=PARTY, received=received, **more)


@pytest.mark.parametrize("moment", ["2026-05-02T00:30:00+08:00", "20260502T003000+0800"])
def test_day_of_calibration_is_the_one_on_the_stations_own_clock(kept, moment):
    given = kept(recorded_at=moment)
    agreed = order(date(2026, 5, 1), recalibration_agreed=True)
    certificate = certify(*given, Inputs(order=agreed)).certificate
    assert certificate.calibrated_on == date(2026, 5, 2)
    assert certificate.due == date(2027, 5, 2)


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    ("agreed", "due"),
    [
        ({}, None),
        ({"interval_months": 6}, date(2026, 11, 2)),
        ({"recalibration_agreed": True}, date(2027, 5, 2)),
        ({"recalibration_agreed": True, "interval_months": 24}, date(2028, 5, 2)),
    ],
)
def test_a_unit_comes_back_only_where_the_order_agrees_on_it(kept, agreed, due):
    calibration = kept()[1]
    assert due_date(date(2026, 5, 2), order(date(2026, 5, 1), **agreed), calibration) == due
    assert due_date(date(2026, 5, 2), None, calibration) is None


def test_day_that_nothing_tells_stays_unknown_and_due_counts_from_the_certificate(kept):
    given = kept()
    agreed = order(date(2026, 5, 1), recalibration_agreed=True)
    certificate = certify(*given, Inputs(order=agreed)).certificate
    assert certificate.calibrated_on is None
    assert certificate.due is not None
    assert certificate.issued_on == date.today()
    assert (certificate.due.year, certificate.due.month) == (
        certificate.issued_on.year + 1, certificate.issued_on.month
    )  # fmt: skip
    (entry,) = certificates.register(given[2])
    assert entry.calibrated_on is None


@pytest.mark.parametrize(
    "inputs",
    [
        Inputs(calibrated_on=date(2026, 5, 2)),
        Inputs(order=order(date(2026, 5, 1), calibrated_on=date(2026, 5, 2))),
    ],
)
def test_papers_may_tell_the_day(kept, inputs):
    assert certify(*kept(), inputs).certificate.calibrated_on == date(2026, 5, 2)


@pytest.mark.parametrize(
    ("statement", "inputs", "says"),
    [
        ({}, Inputs(tolerance=tolerance(model="other")), "test other"),
        (
            {},
            Inputs(tolerance=tolerance(limits=(Limit(item="gyro_x", unit="1", magnitude=1),))),
            "gyro_x",
        ),
        ({"equipment": "table"}, Inputs(), "equipment"),
        ({"equipment": [STANDARD | {"serial": 7}]}, Inputs(), "serial"),
        ({"recorded_at": 5}, Inputs(), "recorded_at"),
        ({"recorded_at": "last week"}, Inputs(), "recorded_at"),
        (
            {"recorded_at": "2026-05-02"},
            Inputs(calibrated_on=date(2026, 5, 3)),
            "2026-05-03",
        ),
        (
            {"recorded_at": "2026-05-02"},
            Inputs(order=order(date(2026, 5, 3))),
            "received",
        ),
        ({}, Inputs(order=order(date(9999, 12, 31))), "after today"),
    ],
)
def test_what_is_refused_leaves_no_draft(kept, statement, inputs, says):
    given = kept(**statement)
    with pytest.raises(Unusable, match=says) as refusal:
        certify(*given, inputs)
    assert "\n" not in str(refusal.value)
    assert certificates.register(given[2]) == []


def test_item_that_is_not_validated_passes_no_unit(kept, monkeypatch, validated):
    """Missing, then there; a record in the home goes before the one that is shipped."""
    given = kept()
    monkeypatch.setattr(record, "shipped", lambda: None)
    without = certify(*given, Inputs(tolerance=tolerance())).certificate
    assert without.decision.verdict == "inconclusive"
    assert any("is not validated for this version" in reason for reason in without.decision.reasons)
    assert without.validation is not None
    assert without.validation[0].startswith("No validation record")
    given[2].path.joinpath("validation.json").write_text(validated.model_dump_json(), "utf-8")
    with_it = certify(*given, Inputs(tolerance=tolerance())).certificate
    assert not any("mimucal validate" in reason for reason in with_it.decision.reasons)
    code = fingerprint("jjf2003")
    assert with_it.validation == (
        f"Estimation validated by the record of 2026-11-21 ({code}): 9 of 9 items",
        f"估计方法经验证，记录 2026-11-21 ({code})：9 项中 9 项通过",
    )


def test_expired_standard_of_the_station_is_a_reason_against_a_pass(kept):
    given = kept(recorded_at="2026-04-01", equipment=[STANDARD])
    inputs = Inputs(tolerance=tolerance(), laboratory=Laboratory(party=PARTY))
    certificate = certify(*given, inputs).certificate
    assert certificate.laboratory is not None
    assert certificate.laboratory.equipment[0].name == "Table"
    assert any("2026-03-31" in reason for reason in certificate.decision.reasons)
    assert certificate.decision.verdict == "inconclusive"


def test_a_run_as_found_is_decided_by_the_same_limits_and_found_with_its_certificate(kept):
    found, before, home = kept(recording_id="before", recorded_at="2026-05-02T09:00:00+08:00")
    left, after, _ = kept(recorded_at="2026-05-02T15:00:00+08:00")
    certificate = certify(
        left, after, home, Inputs(tolerance=tolerance()), (found, before)
    ).certificate
    assert certificate.calibration.run == left.id
    assert certificate.as_found is not None
    assert certificate.as_found.calibration == before
    assert certificate.as_found.calibrated_on == date(2026, 5, 2)
    assert certificate.as_found.decision.document == certificate.decision.document == "d"
    for run in (found, left):
        (entry,) = certificates.of_run(run, home)
        assert entry.number == certificate.number


@pytest.mark.parametrize(
    ("earlier", "later", "says"),
    [
        ({"recorded_at": "2026-05-03"}, {"recorded_at": "2026-05-02"}, "swap them"),
        (
            {"recorded_at": "2026-05-02T09:00:00+02:00"},
            {"recorded_at": "2026-05-02T14:00:00+08:00"},
            "swap them",
        ),
        ({"unit": {"manufacturer": "test", "model": "ideal", "serial": "2"}}, {}, "same unit"),
        ({}, {}, "itself"),
    ],
)
def test_a_run_as_found_that_cannot_be_is_refused(kept, earlier, later, says):
    found, before, home = kept(**earlier)
    left, after, _ = kept(**later)
    with pytest.raises(Unusable, match=says):
        certify(left, after, home, Inputs(tolerance=tolerance()), (found, before))


def test_an_invalid_run_is_refused_unless_its_report_is_asked_for(kept):
    run, calibration, home = kept()
    wrong = Remark(code="clocks_apart", en="Two clocks.", zh="两个时钟。", run="invalid")
    given = (run, calibration.model_copy(update={"remarks": (wrong,)}), home)
    with pytest.raises(Unusable, match="is invalid: Two clocks; measure again"):
        certify(*given, Inputs(tolerance=tolerance()))
    agreed = order(date(2026, 5, 1), recalibration_agreed=True)
    asked = Inputs(tolerance=tolerance(), order=agreed, invalid_run=True)
    reported = certify(*given, asked).certificate
    assert reported.due is None
    assert {decided.verdict for decided in reported.decision.limits} == {"inconclusive"}
    assert "the run is invalid: no decision is made on the unit" in reported.decision.reasons


def test_a_broken_logo_is_one_sentence_and_leaves_no_certificate(kept, monkeypatch):
    monkeypatch.setattr(pdf, "render", render)  # typeset after all
    run, result, home = kept()
    (home.path / "logo.png").write_bytes(b"no picture")
    laboratory = Laboratory(party=PARTY, logo="logo.png", operator="Li")
    with pytest.raises(
        Unusable, match=r"^No certificate was made: it cannot be typeset with the logo of"
    ):
        certify(run, result, home, Inputs(laboratory=laboratory))
    assert certificates.register(home) == []
    assert not list(home.path.glob("certificates/*"))
    (home.path / "logo.png").unlink()
    with pytest.raises(Unusable, match=r"^laboratory\.toml: logo = .*cannot be read"):
        certify(run, result, home, Inputs(laboratory=laboratory))


def test_the_record_has_the_curves_of_the_run_and_those_of_the_units_earlier_certificates(kept):
    run, calibration, home = kept(recorded_at="2026-05-02", recording_id="now")
    shifted = {
        name: item.model_copy(update={"value": {e: v and v + 1.0 for e, v in item.value.items()}})
        for name, item in calibration.items.items()
    }
    earlier = calibration.model_copy(update={"items": shifted})
    first = certify(run, calibration, home, Inputs(order=order(date(2025, 5, 1))))
    before = first.certificate.model_copy(
        update={"number": "L-1", "state": "issued", "calibrated_on": date(2025, 5, 2)}
    )
    assert {each.figure for each in first.certificate.curves} == {"rate-residuals", "tumble"}
    other, again, _ = kept(recorded_at="2026-05-02", recording_id="then")
    keep(before.model_copy(update={"calibration": earlier}), home)
    made = certify(other, again, home, Inputs(order=order(date(2025, 5, 1)))).certificate
    moved = [each for each in made.curves if each.figure == "history"]
    assert {each.labels for each in moved} == {("L-1",)}
    assert [each.y for each in moved] == [pytest.approx((1.0, 0.0))] * len(moved)


def test_a_capability_is_decided_on_while_the_catalogue_keeps_the_result(kept):
    given = kept()
    least = Capability(item="gyro_scale_factor", unit="1", U=0.05, rates_deg_s=(1.0, 400.0))
    laboratory = Laboratory(party=PARTY, capabilities=(least,))
    inputs = Inputs(tolerance=tolerance(), laboratory=laboratory)
    certificate = certify(*given, inputs).certificate
    assert {limit.U for limit in certificate.decision.limits} == {0.05}
    (stored,) = results.of_run(given[0], given[2])
    assert stored.calibration.items == given[1].items
    assert certificate.calibration.items == given[1].items
    wrong = least.model_copy(update={"item": "gyro_scale"})
    refused = Inputs(laboratory=laboratory.model_copy(update={"capabilities": (wrong,)}))
    with pytest.raises(Unusable, match="capability 1 is of 'gyro_scale'"):
        certify(*given, refused)


def test_a_failed_check_of_a_standard_is_a_reason_against_a_pass(kept):
    check = {"checked_on": "2026-02-01", "what": "level", "result": 2.0, "limit": 1.0, "unit": "″"}
    given = kept(recorded_at="2026-03-01", equipment=[STANDARD | {"checks": [check]}])
    inputs = Inputs(tolerance=tolerance(), laboratory=Laboratory(party=PARTY))
    reasons = certify(*given, inputs).certificate.decision.reasons
    assert any("intermediate check of 2026-02-01 (level) found 2 ″" in each for each in reasons)
