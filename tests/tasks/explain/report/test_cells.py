"""Cells show an excess where it is, whatever its course, and noise as noise."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Stream
from tasks.explain.channels import CHANNELS
from tasks.explain.report.before_after import affected, spectrum
from tasks.explain.report.cells import cells_of
from tests.tasks.explain.report.made_report import added_to, explanation, finding, recording


def test_an_offset_and_a_swing_show_in_their_cells_and_nowhere_else() -> None:
    cells = cells_of(explanation(finding()))
    middles = 0.5 * (cells.edges[:-1] + cells.edges[1:])
    first, turns = (middles > 3) & (middles < 33), (middles > 135)
    assert np.median(cells.excess[3, first]) > 10
    assert np.median(cells.excess[4, turns]) > 8
    assert np.median(cells.excess[3, ~first]) < 2
    assert cells.excess[0].max() < 4.5
    assert cells.before[3, first] == pytest.approx(0.05, abs=0.02)
    assert np.abs(cells.after[3, first]).max() < 0.02


def test_cells_begin_and_end_with_the_segments() -> None:
    cells = cells_of(explanation())
    assert {3.0, 33.0, 36.0, 66.0} <= set(np.round(cells.edges, 6))
    assert np.all(np.diff(cells.edges) > 0)
    assert cells.kinds[0] == ""
    assert set(cells.kinds) == {"", "static", "rate", "rotation"}


def test_rows_of_unknown_motion_are_not_known() -> None:
    run = explanation(finding())
    nominal, found = run.nominal.copy(), run.found.copy()
    nominal[:660], found[:660] = np.nan, np.nan
    cells = cells_of(replace(run, nominal=nominal, found=found))
    assert np.isnan(cells.excess[:, cells.edges[1:] <= 33.0]).all()
    assert np.isnan(cells.noise[:, cells.edges[1:] <= 33.0]).all()
    assert np.isfinite(cells.excess[:, cells.edges[:-1] >= 33.0]).all()


def test_a_channel_that_was_not_recorded_is_not_known() -> None:
    run = explanation()
    columns = {name: run.recording.imu.columns[name] for name in CHANNELS[3:]}
    bare = replace(run.recording, imu=Stream(run.recording.imu.t, columns))
    cells = cells_of(replace(run, recording=bare))
    assert np.isnan(cells.excess[:3]).all()
    assert np.isfinite(cells.excess[3:]).all()


def test_noise_that_grows_while_turning_is_no_excess() -> None:
    run = explanation()
    louder = np.where(run.recording.imu.t[:, None] > 69, 1.0, 0.0)
    shaken = added_to(run.recording, 2.0 * louder * recording().imu.stack(CHANNELS)[::-1])
    assert cells_of(replace(run, recording=shaken)).excess.max() < 5.0


def test_the_channels_that_gain_are_shown() -> None:
    run = explanation(finding())
    assert affected(run, cells_of(run)) == [3, 4]


def test_the_spectrum_of_white_noise_is_one_and_a_line_stands_where_it_is() -> None:
    t = np.arange(20_000) / 50.0
    noise = np.random.default_rng(3).normal(size=len(t))
    frequency, power = spectrum(t, noise)
    assert np.mean(power[frequency > 0.1]) == pytest.approx(1.0, abs=0.1)
    frequency, power = spectrum(t, noise + 2 * np.sin(2 * np.pi * 7.0 * t))
    assert frequency[np.argmax(power)] == pytest.approx(7.0, rel=0.1)
