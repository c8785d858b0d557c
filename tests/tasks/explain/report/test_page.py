"""The folder of a report: whole files, one page without anything from elsewhere, the prediction."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyarrow.parquet as pq
import pytest

from schemas.base import Unusable
from schemas.discrepancy import Consequence, Discrepancy
from schemas.recording import Stream
from tasks.explain.explanation import CHANNELS, Explanation
from tasks.explain.report import report_html, write_report
from tasks.explain.report.discrepancy import affected, before_after_svg, cells_of, spectrum
from tasks.explain.report.page import where_svg
from tasks.explain.report.verdict import shares_svg
from tasks.words import LANGUAGES
from tests.tasks.explain.report.made_report import (
    BIAS,
    CHANGE,
    added_to,
    answer,
    explanation,
    finding,
    recording,
    unnamed,
)

DRAWN = ("where", "before_after", "shares")
PICTURES = tuple(f"{name}{ending}.svg" for ending in ("", "-zh") for name in DRAWN)
BLANK = {name: dict.fromkeys(LANGUAGES, "<svg/>") for name in DRAWN}
CHINESE = re.compile("[\u4e00-\u9fff]")
SVG_TEXT = "{http://www.w3.org/2000/svg}text"
NAMES = {"report.html", "report.json", "prediction.parquet", *PICTURES}
CASES = {
    "no_mismatch": explanation(),
    "explained": explanation(finding(indistinguishable=("axis_wobble",))),
    "partly_explained": explanation(finding(), unnamed(), verdict="partly_explained"),
    "unexplained": explanation(unnamed(), verdict="unexplained"),
}


def written(explained: Explanation, folder) -> str:
    discrepancy = answer(explained, (BIAS,), (CHANGE,))
    write_report(discrepancy, explained, folder)
    return (folder / "report.html").read_text(encoding="utf-8")


def in_english(discrepancy: Discrepancy, explained: Explanation) -> dict[str, str]:
    """The pictures by name, without the files."""
    cells = cells_of(explained)
    return {
        "where": where_svg(discrepancy, cells, "en"),
        "before_after": before_after_svg(explained, cells, "en"),
        "shares": shares_svg(discrepancy, "en"),
    }


@pytest.fixture
def unpictured(monkeypatch) -> None:
    """Pictures are not drawn, for tests of what stands beside them."""
    monkeypatch.setattr("tasks.explain.report.page.pictures_of", lambda *_: BLANK)


@pytest.fixture(scope="module")
def report(tmp_path_factory) -> Callable[[str], Path]:
    """The folder of each case's report, written once."""

    @cache
    def folder_of(case: str) -> Path:
        folder = tmp_path_factory.mktemp("report") / "out"
        written(CASES[case], folder)
        return folder

    return folder_of


@pytest.fixture
def page_of(report) -> Callable[[str], str]:
    return lambda case: (report(case) / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("verdict", CASES)
def test_every_verdict_has_a_page_pictures_and_data(verdict, report, page_of):
    folder = report(verdict)
    assert {path.name for path in folder.iterdir()} == NAMES
    assert 'class="badge' in page_of(verdict)
    for name in PICTURES:
        root = ElementTree.fromstring((folder / name).read_bytes())
        assert root.tag.endswith("svg")
    document = Discrepancy.model_validate_json((folder / "report.json").read_bytes())
    assert document.verdict == verdict


@pytest.mark.parametrize("verdict", CASES)
def test_the_page_needs_nothing_from_elsewhere(verdict, page_of):
    page = re.sub(r'xmlns(:xlink)?="[^"]*"', "", page_of(verdict))
    page = re.sub(r'href="#|url\(#', "", page)  # within the page itself
    assert not re.search(r"https?:|//\w|@import|url\(|<link|<script|src=|href=", page)


def test_the_page_holds_both_languages_and_every_picture(page_of):
    page = page_of("explained")
    assert page.count('lang="en"') - 1 == page.count('lang="zh"')  # one more on the page itself
    assert page.count("<svg") == 6
    for words in ("Table not level", "转台不水平", "axis_wobble", "<b>", "不合格 → 合格",
                  "1.234", "mrad", "0.022", "−40.0"):  # fmt: skip
        assert words in page


@pytest.mark.parametrize("verdict", CASES)
def test_the_pictures_of_a_language_have_its_words(verdict, report, page_of):
    for name in PICTURES:
        root = ElementTree.fromstring((report(verdict) / name).read_bytes())
        words = [root.get("aria-label"), *map(content_of, root.iter(SVG_TEXT))]
        if "-zh" not in name:
            assert not any(map(CHINESE.search, words))
            continue
        assert CHINESE.search(words[0])
        allowed = re.compile(r"axis_\w+|(gyro|accel)_\w+|noise|χ|Hz|min|m/s|mm|µm|[a-z]$")
        english = [w for w in words if re.search("[a-z]{4}", w) and not allowed.search(w)]
        assert not english
    page = page_of(verdict)
    assert '<span lang="zh"><svg' in page
    assert '<span lang="en"><svg' in page


def content_of(text: ElementTree.Element) -> str:
    return "".join(text.itertext())


def test_what_was_written_by_others_is_escaped(page_of):
    page = page_of("explained")
    assert "run &lt;7&gt; &amp; more" in page
    assert "a &lt; b" in page


def test_without_findings_the_page_speaks_of_no_certificate_and_no_after(page_of):
    page = page_of("no_mismatch")
    assert "Effect on the certificate</span>" not in page
    assert "with the findings" not in page
    assert "p = 0.41" in page


@pytest.mark.usefixtures("unpictured")
def test_the_prediction_has_a_row_for_each_row_and_keeps_what_is_not_known(tmp_path):
    run = CASES["explained"]
    nominal = run.nominal.copy()
    nominal[10:20] = np.nan
    run = replace(run, nominal=nominal)
    written(run, tmp_path)
    table = pq.read_table(tmp_path / "prediction.parquet")
    expected = ["t", *(f"{c}_{kind}" for c in CHANNELS for kind in ("nominal", "found"))]
    assert table.column_names == expected
    assert table.num_rows == len(run.recording.imu.t)
    read = table["accel_x_nominal"].to_numpy()
    assert np.isnan(read[10:20]).all()
    np.testing.assert_array_equal(read, nominal[:, 3])
    np.testing.assert_array_equal(table["accel_x_found"].to_numpy(), run.found[:, 3])
    np.testing.assert_array_equal(table["t"].to_numpy(), run.recording.imu.t)
    assert pq.ParquetFile(tmp_path / "prediction.parquet").metadata.row_group(0).column(
        0).compression == "ZSTD"  # fmt: skip


@pytest.mark.usefixtures("unpictured")
def test_a_place_that_cannot_be_written_is_refused_with_a_sentence(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(Unusable, match="name another folder"):
        written(CASES["no_mismatch"], tmp_path / "file")


def test_no_known_row_at_all_still_makes_a_report(tmp_path):
    run = CASES["no_mismatch"]
    nothing = np.full_like(run.nominal, np.nan)
    noise = np.full(6, np.nan)
    page = written(replace(run, nominal=nothing, found=nothing, noise=noise), tmp_path)
    assert page.count("<svg") == 4


@pytest.mark.parametrize("size", [1e-9, 1e6])
def test_residuals_of_every_size_fit_into_the_pictures(size):
    run = CASES["explained"]
    readings = run.recording.imu.stack(CHANNELS) * size
    imu = Stream(run.recording.imu.t, dict(zip(CHANNELS, readings.T, strict=True)))
    scaled = replace(run, recording=replace(run.recording, imu=imu), found=run.found * size,
                     noise=run.noise * size)  # fmt: skip
    root = ElementTree.fromstring(before_after_svg(scaled, cells_of(scaled), "en"))
    words = [each.text or "" for each in root.iter(SVG_TEXT)]
    assert max(map(len, words)) < 50
    numbers = re.findall(r"[\d.]+", " ".join(
        each.get("d", "") for each in root.iter("{http://www.w3.org/2000/svg}path")))  # fmt: skip
    assert 0 <= min(map(float, numbers)) <= max(map(float, numbers)) <= 1040


def test_small_values_of_the_certificate_have_a_unit_of_their_size():
    run = CASES["explained"]
    lever = Consequence(item="accel_rate_sensitivity", element="yz", before=4.56e-4, after=None,
                        U=3.7e-5, unit="m")  # fmt: skip
    page = report_html(answer(run, (lever,)), run, BLANK)
    assert '<td class="number">456</td>' in page
    assert ">µm</td>" in page


def test_more_findings_than_colours_still_make_a_report():
    run = explanation(*(finding(0.1 * finding().contribution) for _ in range(8)))
    discrepancy = answer(run, (BIAS,), (CHANGE,))
    assert all("<svg" in svg for svg in in_english(discrepancy, run).values())
    assert report_html(discrepancy, run, BLANK).count('class="card"') == 8


# Cells show an excess where it is, whatever its course, and noise as noise.


def test_an_offset_and_a_swing_show_in_their_cells_and_nowhere_else():
    cells = cells_of(explanation(finding()))
    middles = 0.5 * (cells.edges[:-1] + cells.edges[1:])
    first, turns = (middles > 3) & (middles < 33), (middles > 135)
    assert np.median(cells.excess[3, first]) > 10
    assert np.median(cells.excess[4, turns]) > 8
    assert np.median(cells.excess[3, ~first]) < 2
    assert cells.excess[0].max() < 4.5
    assert cells.before[3, first] == pytest.approx(0.05, abs=0.02)
    assert np.abs(cells.after[3, first]).max() < 0.02


def test_cells_begin_and_end_with_the_segments():
    cells = cells_of(explanation())
    assert {3.0, 33.0, 36.0, 66.0} <= set(np.round(cells.edges, 6))
    assert np.all(np.diff(cells.edges) > 0)
    assert cells.kinds[0] == ""
    assert set(cells.kinds) == {"", "static", "rate", "rotation"}


def test_rows_of_unknown_motion_are_not_known():
    run = explanation(finding())
    nominal, found = run.nominal.copy(), run.found.copy()
    nominal[:660], found[:660] = np.nan, np.nan
    cells = cells_of(replace(run, nominal=nominal, found=found))
    assert np.isnan(cells.excess[:, cells.edges[1:] <= 33.0]).all()
    assert np.isnan(cells.noise[:, cells.edges[1:] <= 33.0]).all()
    assert np.isfinite(cells.excess[:, cells.edges[:-1] >= 33.0]).all()


def test_a_channel_that_was_not_recorded_is_not_known():
    run = explanation()
    columns = {name: run.recording.imu.columns[name] for name in CHANNELS[3:]}
    bare = replace(run.recording, imu=Stream(run.recording.imu.t, columns))
    cells = cells_of(replace(run, recording=bare))
    assert np.isnan(cells.excess[:3]).all()
    assert np.isfinite(cells.excess[3:]).all()


def test_noise_that_grows_while_turning_is_no_excess():
    run = explanation()
    louder = np.where(run.recording.imu.t[:, None] > 69, 1.0, 0.0)
    shaken = added_to(run.recording, 2.0 * louder * recording().imu.stack(CHANNELS)[::-1])
    assert cells_of(replace(run, recording=shaken)).excess.max() < 5.0


def test_the_channels_that_gain_are_shown():
    run = explanation(finding())
    assert affected(run, cells_of(run)) == [3, 4]


def test_the_spectrum_of_white_noise_is_one_and_a_line_stands_where_it_is():
    t = np.arange(20_000) / 50.0
    noise = np.random.default_rng(3).normal(size=len(t))
    frequency, power = spectrum(t, noise)
    assert np.mean(power[frequency > 0.1]) == pytest.approx(1.0, abs=0.1)
    frequency, power = spectrum(t, noise + 2 * np.sin(2 * np.pi * 7.0 * t))
    assert frequency[np.argmax(power)] == pytest.approx(7.0, rel=0.1)
