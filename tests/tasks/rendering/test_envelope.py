"""A long signal is shown with every peak in it."""

import numpy as np
import pytest

from tasks.rendering import envelope


@pytest.mark.parametrize("bins", [1, 7, 100])
def test_a_peak_of_one_row_is_kept_wherever_it_is(bins):
    t = np.arange(5000) / 100
    for row, peak in ((0, 9.0), (1234, -9.0), (4999, 9.0)):
        values = np.sin(t)
        values[row] = peak
        shown = envelope(t, values, bins)
        assert len(shown.t) == bins
        assert (shown.low.min(), shown.high.max()) == (values.min(), values.max())


def test_every_row_is_within_the_band_of_its_bin():
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.uniform(0.001, 0.1, 3000))
    values = rng.normal(size=3000)
    shown = envelope(t, values, 50)
    bin_of = np.searchsorted(shown.t, t, side="right") - 1
    assert (shown.low[bin_of] <= values).all()
    assert (values <= shown.high[bin_of]).all()
    assert np.isin(shown.low, values).all()


def test_few_rows_are_shown_as_they_are():
    t = np.arange(20.0)
    shown = envelope(t, t**2, 10)
    assert not shown.is_reduced
    assert shown.low is shown.high
    assert list(shown.low) == list(t**2)


def test_a_gap_gives_no_bin_and_what_is_no_number_hides_nothing():
    t = np.concatenate([np.arange(100.0), 1000 + np.arange(100.0)])
    values = np.ones(200)
    values[::2] = np.nan
    shown = envelope(t, values, 20)
    assert not ((shown.t > 110) & (shown.t < 990)).any()
    assert (shown.high == 1.0).all()
