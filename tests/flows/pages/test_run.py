"""The page of one run says what the store says of it, and shows what others wrote as text."""

import json
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient
from plotly.utils import PlotlyJSONEncoder

from flows.pages.app import make_app
from flows.pages.parts import View, seen_by
from flows.pages.run import lineage
from flows.pages.run import signal_data as signals
from flows.pages.run_data import RunQuestion, RunShown, SignalsQuestion, data
from flows.pages.shell import page_at
from schemas.base import Unusable
from storage.catalogue import results, runs
from storage.catalogue.runs import find
from storage.home import Home
from tests.drafts import UNDECIDED, calibration_of, draft, recording_of

HOSTILE = "<img src=x onerror=alert(1)>\"'`{}\U0001f600../../" + "x" * 10_000


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Home:
    home = Home(tmp_path_factory.mktemp("run"))
    draft(home, "1")
    runs.add(recording_of(HOSTILE), home)
    return home


@pytest.fixture(scope="module")
def shown(store: Home) -> RunShown:
    return data(RunQuestion(id="run of 1"), store)


@pytest.fixture(scope="module")
def client(store: Home) -> FlaskClient:
    return make_app(store).server.test_client()


def test_values_limits_and_margin_are_those_of_the_certificate(shown: RunShown) -> None:
    (element,) = shown.elements
    assert (element.value, element.U, element.value_text, element.U_text) == (
        0.25, 0.02, "0.250", "0.020",
    )  # fmt: skip
    (limit,) = element.limits
    assert (limit.text, limit.decision.verdict) == ("±1", "pass")
    assert limit.margin == pytest.approx(0.75 / 0.02)
    assert shown.limits_of == shown.certificates[0].number


@pytest.mark.parametrize(("language", "name"), [("zh", "所用重力加速度"), ("en", "gravity used")])
def test_settings_have_the_names_that_a_certificate_prints(
    shown: RunShown, language: str, name: str
) -> None:
    made = shown.model_copy(update={"settings": {"gravity_m_s2": 9.8015, "latitude_deg": None}})
    written = json.dumps(
        seen_by(View(language), lineage, made).to_plotly_json(), cls=PlotlyJSONEncoder
    )
    assert json.dumps(name)[1:-1] in written
    assert "9.8015 m/s" in written
    assert "gravity_m_s2" not in written


def test_limits_of_an_earlier_result_do_not_stand_beside_a_new_one(tmp_path: Path) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    run = find("run of 1", home)
    results.save(calibration_of(run, bias=0.3), home)
    again = data(RunQuestion(id=run.id), home)
    assert again.limits_of is None
    assert again.elements[0].limits == ()
    assert again.results[1].supersedes == again.results[0].id


def test_raw_rows_between_two_times_are_shown_whole_or_with_their_extremes(store: Home) -> None:
    run = find("run of 1", store)
    raw = runs.load(run, store).imu
    part = signals(SignalsQuestion(run=run.id, channel="accel_z", since=1.0, until=2.0), store)
    rows = raw.rows(1.0, 2.0)
    assert part.low == tuple(raw.columns["accel_z"][rows])
    every = signals(SignalsQuestion(run=run.id, channel="accel_z", bins=10), store)
    assert every.rows == len(raw)
    assert max(value for value in every.high if value is not None) == np.max(raw.columns["accel_z"])
    with pytest.raises(Unusable, match="no channel nothing in a stream imu"):
        signals(SignalsQuestion(run=run.id, channel="nothing"), store)


def test_what_others_wrote_is_text_in_every_answer(client: FlaskClient, store: Home) -> None:
    run = find(f"run of {HOSTILE}", store)
    answer = client.get(f"/api/v1/run?id={run.id}")
    assert answer.mimetype == "application/json"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert answer.json["run"]["serial"] == HOSTILE
    page, _, _ = seen_by(View(), page_at, "/run", f"?id={run.id}", store)
    assert "dangerously" not in str(page)


def test_a_certificate_is_given_as_it_is_kept_and_no_other_file(
    client: FlaskClient, shown: RunShown, store: Home
) -> None:
    number = shown.certificates[0].number
    assert client.get(f"/certificate/{number}.pdf").data.startswith(b"%PDF")
    for bad in ("none", "..%2fcatalog", "%00"):
        assert client.get(f"/certificate/{bad}.pdf").mimetype != "application/pdf"


def test_a_run_says_why_its_certificate_is_inconclusive_though_every_limit_passes(
    tmp_path: Path,
) -> None:
    draft(Home(tmp_path), "1", decision=UNDECIDED)
    shown = data(RunQuestion(id="run of 1"), Home(tmp_path))
    assert [limit.decision.verdict for e in shown.elements for limit in e.limits] == ["pass"]
    page, _, _ = seen_by(View("zh"), page_at, "/run", "?id=run of 1", Home(tmp_path))
    assert "证书无法判定的原因" in str(page)
    assert "未提供该型号的允许限" in str(page)


def test_a_run_that_is_not_there_is_a_sentence_on_the_page(store: Home) -> None:
    page, _, stays = seen_by(View("zh"), page_at, "/run", "?id=nothing", store)
    assert "没有测量记录 nothing" in str(page)
    assert stays
