"""The mismatch page: what the last review and each run's own findings say, and what they touch."""

import shutil
import time
from datetime import UTC, date, datetime
from pathlib import Path

import pytest

from flows.pages.app import make_app
from flows.pages.discrepancy import PAGE, DiscrepancyQuestion, data
from flows.pages.parts import View, seen_by
from schemas.discrepancy import (
    Carrier,
    Consequence,
    Detection,
    Discrepancy,
    EvidenceFor,
    FoundParameter,
    HeldOut,
    KeptReview,
    Moment,
    PooledEvidence,
    PooledValue,
    ReportedFinding,
    Review,
    ReviewFinding,
    Touched,
)
from schemas.text import Remark, Statement
from storage import dataframes, run_statistics
from storage.catalogue import discrepancies, results, runs
from storage.home import Home
from tests.drafts import calibration_of, recording_of
from tests.proof.line import Line

ANSWER = Statement(en="Said.", zh="说。")
TILT = FoundParameter(name="east", value=1e-4, unit="rad", u=1e-5)
EVERYTHING = DiscrepancyQuestion()


def discrepancy(effect: str | None) -> Discrepancy:
    """An answer with one finding, or none."""
    moved = (
        Consequence(item="gyro_bias", element="x", before=0.0, after=1.0, U=2.0, unit="deg/s"),
        Consequence(item="accel_bias", element="y", before=0.0, after=-3.0, U=2.0, unit="m/s2"),
        Consequence(item="accel_bias", element="z", before=None, after=-3.0, U=2.0, unit="m/s2"),
    )
    finding = [
        ReportedFinding(
            effect=name, family="table", title=ANSWER, channels=("accel_x",), where=(),
            parameters=(TILT,), evidence=EvidenceFor(delta_bic=10.0, held_out_gain_nats=1.0),
            share=0.9, homogeneity_p=None, group=None, equation="", source="",
            consequences=moved, next=ANSWER, statement=ANSWER,
        )
        for name in [effect]
        if name is not None
    ]  # fmt: skip
    held_out = HeldOut(rms_ratio={}, chi2_per_dof_before=1.0, chi2_per_dof_after=1.0)
    return Discrepancy(
        recording_id="r", code_version="1", model=ANSWER,
        verdict="explained" if finding else "no_mismatch",
        detection=Detection(p_value=0.1, false_alarm_rate=0.005), explained_share=1.0,
        left_over={}, findings=tuple(finding), held_out=held_out, statement=ANSWER,
    )  # fmt: skip


def review(
    level: str, carrier: str, since: str, without: str = "", touched: tuple[Touched, ...] = ()
) -> KeptReview:
    moment = Moment(run="r1", at=since, earliest=since, latest=since, without=without)
    value = PooledValue(name="east", value=1e-4, unit="rad", u=1e-5, spread=0.0)
    evidence = PooledEvidence(delta_bic=100.0, per_run_z_median=3.0, runs_that_show_it=5, runs=6)
    finding = ReviewFinding.model_validate({
        "effect": "axis_tilt", "level": level, "carrier": carrier, "since": moment,
        "parameters": (value,), "evidence": evidence, "statement": ANSWER, "touched": touched,
    })  # fmt: skip
    answer = Review(
        runs=6, verdict="explained", detection=Detection(p_value=0.0, false_alarm_rate=0.01),
        findings=(finding,), statement=ANSWER,
    )  # fmt: skip
    return KeptReview(at=datetime(2026, 11, 1, tzinfo=UTC), review=answer)


@pytest.fixture(scope="module")
def home(line_store: tuple[Home, Line], tmp_path_factory: pytest.TempPathFactory) -> Home:
    """The line, with two runs of ST-01 and one of ST-02 explained; one of ST-01 shows a tilt."""
    home = Home(tmp_path_factory.mktemp("mismatch") / "home")
    shutil.copytree(line_store[0].path, home.path)
    table = dataframes.runs(home).sort_values("recorded_on")
    first, second = table[table["station"] == "ST-01"]["id"].iloc[:2]
    other = table[table["station"] == "ST-02"]["id"].iloc[0]
    for run, effect in ((first, None), (second, "axis_tilt"), (other, "lever_arm")):
        at = datetime(2026, 11, 1, tzinfo=UTC)
        discrepancies.keep(runs.find(run, home), discrepancy(effect), "<p>told</p>", at, home)
    return home


def test_effects_are_counted_by_station_unit_and_model(home: Home) -> None:
    shown = data(EVERYTHING, home)
    assert (shown.explained, shown.runs) == (3, 60)
    tilt = next(each for each in shown.effects if each.effect == "axis_tilt")
    (station,) = tilt.by_station
    assert (station.name, station.shown, station.of) == ("ST-01", 1, 2)
    assert station.since == tilt.since == tilt.until
    assert [(m.item, m.in_U) for m in tilt.moved] == [("accel_bias", -1.5), ("gyro_bias", 0.5)]
    own = dataframes.certificates(home)
    run = next(r.run for r in shown.newest if any(f.effect == "axis_tilt" for f in r.findings))
    assert tilt.papers.issued + tilt.papers.drafts == (own["run"] == run).sum()


def test_a_choice_of_station_or_effect_takes_the_runs_that_meet_it(home: Home) -> None:
    there = data(DiscrepancyQuestion(station="ST-01"), home)
    assert there.explained == 2
    assert [each.effect for each in there.effects] == ["axis_tilt"]
    arm = data(DiscrepancyQuestion(effect="lever_arm"), home)
    assert [run.station for run in arm.newest] == ["ST-02"]
    assert data(DiscrepancyQuestion(station="none"), home).explained == 0


def test_a_run_that_is_explained_again_has_the_new_answer_alone(home: Home) -> None:
    clean = next(run.run for run in data(EVERYTHING, home).newest if not run.findings)
    run = runs.find(clean, home)
    before = discrepancies.explained_runs(home)
    at = datetime(2026, 11, 2, tzinfo=UTC)
    discrepancies.keep(run, discrepancy("time_offset"), "<p>again</p>", at, home)
    assert len(discrepancies.explained_runs(home)) == len(before)
    assert discrepancies.report_of(run, home) == b"<p>again</p>"
    discrepancies.keep(run, discrepancy(None), "<p>told</p>", at, home)


@pytest.mark.parametrize(("level", "carrier", "field"), [
    ("station", "ST-01", "station"), ("unit", "SN0001", "serial"), ("model", "MX-110", "model"),
])  # fmt: skip
def test_a_carrier_of_the_last_review_names_its_certificates(
    home: Home, level: str, carrier: str, field: str
) -> None:
    run_statistics.keep_review(review(level, carrier, "2025-01-05T08:00:00+00:00"), home)
    shown = data(EVERYTHING, home).review
    assert shown is not None
    (carried,) = shown.findings
    assert carried.query == {field: carrier, "since": "2025-01-05"}
    own = dataframes.certificates(home)
    later = own[(own[field] == carrier) & (own["recorded_on"] >= date(2025, 1, 5))]
    assert carried.papers is not None
    assert carried.papers.issued == (later["state"] == "issued").sum() > 0
    assert set(carried.papers.numbers) <= set(later["number"])


def test_certificates_of_the_time_in_which_it_may_have_begun_are_counted_beside(home: Home) -> None:
    run_statistics.keep_review(
        review("station", "ST-01", "2025-01-05T08:00", "2024-03-10T08:00"), home
    )
    shown = data(EVERYTHING, home).review
    assert shown is not None
    (between,) = shown.findings[0].uncertain
    assert between.query == {"station": "ST-01", "since": "2024-03-11", "until": "2025-01-04"}
    own = dataframes.certificates(home)
    there = own[(own["station"] == "ST-01") & (own["state"] == "issued")]
    days = there["recorded_on"]
    inside = (days > date(2024, 3, 10)) & (days < date(2025, 1, 5))
    assert between.papers.issued == inside.sum() > 0
    text = str(seen_by(View(), PAGE.layout, data(EVERYTHING, home), EVERYTHING).to_plotly_json())
    assert "between 2024-03-10 and 2025-01-05" in text


def test_a_touched_certificate_says_by_how_much_and_leads_to_its_run(home: Home) -> None:
    own = dataframes.certificates(home).iloc[0]
    by = {"accel_bias": -3.5, "gyro_bias": 0.5}
    touched = tuple(
        Touched(certificate=own["number"], item=item, element="x", in_U=in_U)
        for item, in_U in by.items()
    )
    run_statistics.keep_review(review("station", "ST-01", "2025-01-05", touched=touched), home)
    shown = data(EVERYTHING, home)
    assert shown.review is not None
    (paper,) = shown.review.findings[0].moved
    assert (paper.number, paper.run) == (own["number"], own["run"])
    assert {moved.item: moved.in_U for moved in paper.moved} == by
    text = str(seen_by(View(), PAGE.layout, shown, EVERYTHING).to_plotly_json())
    assert f"/run?id={own['run']}" in text
    assert "B_ax\\xa0−3.5\\xa0U" in text


def test_an_effect_of_single_runs_leads_to_these_runs(home: Home) -> None:
    text = str(seen_by(View(), PAGE.layout, data(EVERYTHING, home), EVERYTHING).to_plotly_json())
    assert "'/mismatch?effect=axis_tilt'" in text
    assert "'/mismatch?effect=axis_tilt&station=ST-01'" in text


def test_an_invalid_run_is_marked_and_its_findings_count_for_no_effect(tmp_path: Path) -> None:
    home, invalid = Home(tmp_path), Remark(en="Said.", zh="说。", code="clock", run="invalid")
    for serial, changes in (("1", {}), ("2", {"remarks": (invalid,)})):
        run, _ = runs.add(recording_of(serial), home)
        results.save(calibration_of(run, **changes), home)
        at = datetime(2026, 11, 1, tzinfo=UTC)
        discrepancies.keep(run, discrepancy("axis_tilt"), "<p>", at, home)
    shown = data(EVERYTHING, home)
    (tilt,) = shown.effects
    assert [(unit.name, unit.model, unit.shown, unit.of) for unit in tilt.by_unit] == [
        ("1", "U", 1, 1)
    ]
    assert {run.serial: run.validity for run in shown.newest} == {"1": "valid", "2": "invalid"}
    text = str(seen_by(View(), PAGE.layout, shown, EVERYTHING).to_plotly_json())
    assert "One of these is invalid" in text
    assert "state state-bad" in text


def test_a_carrier_stands_once_with_all_its_effects_and_what_to_do(
    home: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = review("unit", "MX-110 SN0001", "2025-01-05T20:00:00+00:00")
    (finding,) = kept.review.findings
    lever = finding.model_copy(update={
        "effect": "lever_arm", "statement": Statement(en="χ² = 860778", zh="χ² = 860778"),
        "alternatives": (Carrier(level="station", carrier="ST-01", delta_bic=1.0),),
    })  # fmt: skip
    both = kept.review.model_copy(update={"findings": (finding, lever)})
    run_statistics.keep_review(kept.model_copy(update={"review": both}), home)
    monkeypatch.setenv("TZ", "Asia/Shanghai")
    time.tzset()
    text = str(seen_by(View(), PAGE.layout, data(EVERYTHING, home), EVERYTHING).to_plotly_json())
    monkeypatch.undo()
    time.tzset()
    assert text.count("Unit MX-110 SN0001") == 1
    assert "860778" not in text
    assert "3 times its standard deviation" in text
    assert "a run of the unit on another station would" in text
    assert "put a level on the table base" in text
    assert "'Since'" in text
    assert "2025-01-06 (95 %" in text  # where the pages are served


def test_the_report_of_a_run_is_given_as_it_was_kept(home: Home) -> None:
    client = make_app(home).server.test_client()
    run = data(EVERYTHING, home).newest[0].run
    given = client.get(f"/explained/{run}.html")
    assert given.data == b"<p>told</p>"
    assert given.mimetype == "text/html"
    assert client.get("/explained/none.html").status_code == 404
    without = dataframes.runs(home)["id"].iloc[-1]
    assert client.get(f"/explained/{without}.html").status_code == 404
