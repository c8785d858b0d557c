"""One record of what was used: papers that contradict a run are refused, with both values."""

import json
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from typing import Any

import pytest

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Certificate, Laboratory
from schemas.laboratory import MeasurementStandard
from schemas.orders import AmendOrder
from schemas.recording import Recording
from schemas.tolerance import Limit, Tolerance
from storage.catalogue import certificates, equipment, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.certificate.content import changes, content
from tasks.stages.certificate_inputs import CertificateInputs as Inputs
from tasks.stages.certify import certify, keep_draft
from tasks.stages.estimate import estimate, standards_in_use
from tasks.stages.issue import amendment, check, issue
from tasks.validation import record
from tasks.words import say
from tests.drafts import LABORATORY, MORNING, ORDER, certificate_of

pytestmark = pytest.mark.usefixtures("unprinted")

Given = tuple[Run, Home]
BOUNDS = {
    "rate": 1e-5, "ripple": 5e-4, "position": 5e-5, "repeatability": 2.4e-5, "axes": 5e-5,
    "fixture": 5e-5, "level": 5e-5, "gravity": 1e-5, "latitude": 1e-4,
}  # fmt: skip


def standard(**changes: Any) -> MeasurementStandard:
    """A traceable table whose certificate states every limit."""
    limits = {
        name: {"half_width": bound, "distribution": "rectangular"} for name, bound in BOUNDS.items()
    }
    fields = {
        "name": "Table", "name_zh": "转台", "serial": "VIRTUAL-T1", "accuracy": "",
        "certificate": "C-1", "valid_until": "2099-12-31", "limits": limits,
    }  # fmt: skip
    return MeasurementStandard.model_validate_json(json.dumps(fields | changes))


def laboratory(*listed: MeasurementStandard, **more: Any) -> Laboratory:
    return LABORATORY.model_copy(update={"equipment": listed, **more})


TOLERANCE = Tolerance(
    manufacturer="test", model="ideal", document="d",
    limits=(Limit(item="gyro_scale_factor", unit="1", lower=0.9, upper=1.1),),
)  # fmt: skip
ASKED = Inputs(
    tolerance=TOLERANCE,
    order=ORDER.model_copy(update={"waived_conditions": ("largest_rate", "environment")}),
    by="Wang",
)


@pytest.fixture(scope="module")
def recorded(ideal_run) -> Recording:
    return ideal_run()


@pytest.fixture
def kept(recorded, tmp_path, monkeypatch, validated) -> Callable[..., Given]:
    """Keeps a run whose manifest names some standards, and more, and its result."""
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    monkeypatch.setattr(record, "shipped", lambda: validated)
    home = Home(tmp_path / "home")

    def build(*used: MeasurementStandard, **more: Any) -> Given:
        named = [each.model_dump(mode="json") for each in used]
        fields = {"equipment": named, "recorded_at": "2026-05-02", "operator": "Sun"} | more
        manifest = recorded.manifest.model_validate(recorded.manifest.model_dump() | fields)
        run, _ = runs.add(replace(recorded, manifest=manifest), home)
        return run, home

    return build


def result_of(run: Run, home: Home, laboratory: Laboratory) -> Calibration:
    """Without what is open of a run without encoders, so that standards and limits alone count."""
    result = estimate(run, home, None, laboratory)
    remarks = tuple(each for each in result.remarks if not each.blocks_pass)
    return result.model_copy(update={"remarks": remarks})


def made(given: Given, laboratory: Laboratory, **more: Any) -> Certificate:
    run, home = given
    result = result_of(run, home, laboratory)
    return certify(run, result, home, replace(ASKED, laboratory=laboratory, **more)).certificate


def refused(given: Given, laboratory: Laboratory, **more: Any) -> str:
    with pytest.raises(Unusable) as fault:
        made(given, laboratory, **more)
    assert certificates.register(given[1]) == []
    assert "\n" not in str(fault.value)
    return str(fault.value)


def test_the_standards_of_a_certificate_are_those_of_the_run(kept):
    certificate = made(kept(standard()), laboratory())
    assert certificate.laboratory is not None
    assert [each.serial for each in certificate.laboratory.equipment] == ["VIRTUAL-T1"]
    assert certificate.decision.verdict == "pass", certificate.decision.reasons


@pytest.mark.parametrize(
    ("stated", "both"),
    [
        ({"serial": "TT-3000-07"}, ("TT-3000-07", "VIRTUAL-T1")),
        ({"certificate": "C-9"}, ("certificate = C-1", "C-9")),
        ({"traceable": False}, ("traceable = true", "false")),
        ({"valid_until": "2098-01-01"}, ("valid_until = 2099-12-31", "2098-01-01")),
        (
            {"limits": {"rate": {"half_width": 2e-6, "distribution": "rectangular"}}},
            ("limits.rate = 1e-05", "2e-06"),
        ),
    ],
)
def test_settings_that_contradict_the_run_are_refused_with_both_values(kept, stated, both):
    sentence = refused(kept(standard()), laboratory(standard(**stated)))
    assert [each for each in both if each not in sentence] == []
    assert "laboratory.toml" in sentence


def test_a_register_that_contradicts_the_run_is_refused_and_a_renewal_is_none(kept):
    given = kept(standard(traceable=False, calibrated_on="2025-01-01"))
    equipment.add([standard(calibrated_on="2025-01-01")], given[1], "Li")
    assert "traceable = false, but the register says true" in refused(given, laboratory())
    newer = standard(certificate="C-2", calibrated_on="2026-01-01")
    equipment.renew([newer], given[1], "Li")
    certificate = made(given, laboratory())
    assert certificate.laboratory is not None
    assert certificate.laboratory.equipment == (newer,)


def test_a_draft_that_lists_other_standards_than_its_run_is_not_issued(kept):
    """As an earlier version left it: the settings named what the run did not use."""
    run, home = kept(standard(traceable=False))
    manifest, result = runs.load(run, home).manifest, estimate(run, home)
    paper = laboratory(standard(serial="TT-3000-07"))
    day = date(2026, 5, 2)
    draft = certificate_of(
        run, result, laboratory=paper, manifest=manifest, calibrated_on=day, due=None
    )
    key = keep_draft(draft, home, MORNING).certificate.number
    with pytest.raises(Unusable, match=r"TT-3000-07.*VIRTUAL-T1"):
        check(key, home, "Li")


@pytest.mark.parametrize("bare", [{"traceable": False}, {"certificate": ""}])
def test_nothing_passes_is_traceable_or_accredited_through_a_standard_that_is_not(kept, bare):
    """Whatever limits its file states."""
    second = standard(serial="F-1", name="Fixture", limits={}, accuracy="3″")
    for used in ([standard(**bare)], [standard(), second.model_copy(update=bare)]):
        certificate = made(kept(*used), laboratory(accreditation="CNAS L1234"))
        assert {each.verdict for each in certificate.decision.limits} == {"pass"}
        assert certificate.decision.verdict == "inconclusive"
        (reason,) = certificate.decision.reasons
        assert "no unit passes on a measurement standard without metrological trace" in reason
        printed = content(certificate)
        traced = say(printed.traceability, "en")
        assert "none is given for" in traced or "no metrological traceability" in traced
        assert [f for f in printed.laboratory_fields if f.label.id.endswith("accreditation")] == []
        assert any("outside the accreditation" in say(each, "en") for each in printed.statement)


def test_a_simulation_passes_on_virtual_standards_and_says_so_on_every_page(kept):
    virtual = {"traceable": False, "virtual": True}
    given = kept(standard(**virtual))
    certificate = made(given, laboratory(accreditation="CNAS L1234"))
    assert certificate.decision.verdict == "pass"
    printed = content(certificate.model_copy(update={"state": "issued"}))
    assert "VIRTUAL" in say(printed.title, "en")  # in the head of every page
    assert printed.watermark is not None
    assert say(printed.watermark, "zh") == "虚拟"
    assert "no metrological traceability" in say(printed.traceability, "en")
    assert [f for f in printed.laboratory_fields if f.label.id.endswith("accreditation")] == []


def test_nobody_gets_rid_of_what_is_virtual_by_leaving_it_out(kept):
    """Neither in the register nor beside a real standard."""
    run, home = kept(standard(traceable=False, virtual=True))
    renewed = standard(certificate="C-2", calibrated_on="2020-01-01")
    equipment.add([renewed], home, "Li")
    (used,) = standards_in_use(runs.load(run, home).manifest, home, None, date(2026, 5, 2))
    assert (used.certificate, used.virtual) == ("C-2", True)
    mixed = kept(standard(traceable=False, virtual=True), standard(serial="F-1"))
    assert made(mixed, laboratory()).decision.verdict == "inconclusive"


def test_a_run_as_found_has_its_own_standards(kept):
    found = kept(standard(traceable=False), recording_id="before")
    left = kept(standard())
    results = [result_of(*each, laboratory()) for each in (found, left)]
    inputs = replace(ASKED, laboratory=laboratory())
    made = certify(left[0], results[1], left[1], inputs, (found[0], results[0])).certificate
    assert made.as_found is not None
    assert (made.as_found.decision.verdict, made.decision.verdict) == ("inconclusive", "pass")
    inputs = replace(ASKED, laboratory=laboratory(standard()))
    with pytest.raises(Unusable, match="traceable = false, but laboratory"):
        certify(left[0], results[1], left[1], inputs, (found[0], results[0]))


def test_the_day_of_the_first_row_counts_where_no_other_is_recorded(kept):
    given = kept(standard(), recorded_at=None, acquired_at="2026-05-02T23:30:00+00:00")
    agreed = ORDER.model_copy(update={"interval_months": 12})
    certificate = made(given, laboratory(), order=agreed)
    assert certificate.calibrated_on == date(2026, 5, 2)
    assert certificate.due == date(2027, 5, 2)
    local = made(given, laboratory(), order=agreed, calibrated_on=date(2026, 5, 3))
    assert local.calibrated_on == date(2026, 5, 3)  # east of Greenwich it was the next day
    with pytest.raises(Unusable, match="acquired_at = 2026-05-02"):
        made(given, laboratory(), calibrated_on=date(2026, 5, 4))


def test_who_measured_is_the_operator_and_not_who_drafted(kept):
    certificate = made(kept(standard()), laboratory())
    assert say(content(certificate).signatures[0].name, "en") == "Sun"
    sentence = refused_operator(kept(standard(), recording_id="other"))
    assert "--operator names Qian" in sentence
    assert "operator = Sun" in sentence
    unsaid = made(kept(standard(), operator=None), laboratory(), operator="Qian")
    assert say(content(unsaid).signatures[0].name, "en") == "Qian"
    unknown = made(kept(standard(), operator=None, recording_id="x"), laboratory())
    assert say(content(unknown).signatures[0].name, "en") == "not given"


def refused_operator(given: Given) -> str:
    with pytest.raises(Unusable) as fault:
        made(given, laboratory(), operator="Qian")
    return str(fault.value)


def issued(given: Given, laboratory: Laboratory) -> Certificate:
    key = made(given, laboratory).number
    check(key, given[1], "Li")
    return issue(key, given[1], "Zhao").certificate


def amended(old: Certificate, given: Given, **order: Any) -> Certificate:
    asked = AmendOrder(certificate=old.number, by="Wang", why="the client's address", **order)
    new = amendment(asked, given[1])
    assert new.inputs.laboratory is not None
    result = result_of(*given, new.inputs.laboratory)
    return certify(given[0], result, given[1], new.inputs, None, new.replaces).certificate


def test_an_amendment_keeps_verdict_and_limits_and_prints_what_is_different(kept):
    given = kept(standard())
    old = issued(given, laboratory())
    (given[1].path / "tolerances").mkdir()  # limits of the home are others by now
    other = TOLERANCE.limits[0].model_copy(update={"lower": 1.5, "upper": 2.0})
    text = TOLERANCE.model_copy(update={"limits": (other,)}).model_dump_json(exclude_none=True)
    (given[1].path / "tolerances" / "ideal.json").write_text(text, encoding="utf-8")
    assert ASKED.order is not None
    client = ASKED.order.client.model_copy(update={"address": "9 New Road", "address_zh": "新路"})
    new = amended(old, given, client_order=ASKED.order.model_copy(update={"client": client}))
    assert (old.decision.verdict, new.decision) == ("pass", old.decision)
    assert new.tolerance == old.tolerance == TOLERANCE
    assert (new.laboratory, new.calibrated_on) == (old.laboratory, old.calibrated_on)
    assert new.replaces is not None
    (change,) = new.replaces.changes
    assert (change.what.en, change.before.en, change.after.en) == (
        "Address of the client", "2 Road", "9 New Road"
    )  # fmt: skip
    (sentence,) = changes(new.replaces)
    assert sentence in content(new).statement
    assert say(sentence, "en").startswith(f"Changed from certificate {old.number}: ")


def test_an_amendment_that_changes_limits_prints_verdict_and_document(kept):
    given = kept(standard())
    old = issued(given, laboratory())
    tight = TOLERANCE.limits[0].model_copy(update={"lower": 1.5, "upper": 2.0})
    file = given[1].path / "tight.json"
    limits = TOLERANCE.model_copy(update={"limits": (tight,), "document": "e"})
    file.write_text(limits.model_dump_json(exclude_none=True), encoding="utf-8")
    new = amended(old, given, tolerance=str(file))
    assert new.replaces is not None
    changed = {each.what.en: (each.before.en, each.after.en) for each in new.replaces.changes}
    assert changed["Verdict"] == ("pass", "fail")
    assert ("d", "e") in changed.values()


def test_limits_that_an_earlier_record_does_not_hold_are_asked_for(kept):
    run, home = kept(standard())
    manifest, result = runs.load(run, home).manifest, estimate(run, home)
    paper = laboratory(standard())
    draft = certificate_of(
        run, result, laboratory=paper, manifest=manifest, tolerance=None, due=None,
        calibrated_on=date(2026, 5, 2),
    )  # fmt: skip
    key = keep_draft(draft, home, MORNING).certificate.number
    check(key, home, "Li")
    number = issue(key, home, "Zhao").certificate.number
    with pytest.raises(Unusable, match="give them with --tolerance"):
        amendment(AmendOrder(certificate=number, by="Wang", why="x"), home)
