"""Which axis reads its memory, and of what; the states have tests of their own."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.model.term import STILL, SensorTerm
from tasks.model.terms.hysteresis import candidates, hysteresis, relaxed
from tests.tasks.model.table_run import T, motion, read, recording

RUN = motion()
EVERY = [term for term in candidates(recording(), RUN) if isinstance(term, SensorTerm)]


def test_each_gyro_has_a_memory_of_its_own_axis():
    sizes = [1e-3, 2e-3, -3e-3]
    change = read((hysteresis(0.3),), sizes) - read((), [])
    step = np.diff(T, prepend=0.0)
    states = np.column_stack([relaxed(rate, step, 0.3, STILL) for rate in RUN.rate.T])
    assert change[:, :3] == pytest.approx(states * sizes, abs=1e-9)
    assert not change[:, 3:].any()


@pytest.mark.parametrize("term", EVERY, ids=lambda term: term.equation)
def test_a_memory_is_no_line_of_what_is_felt_and_is_known_everywhere(term):
    unknown = np.where((T > 5) & (T < 6), np.nan, RUN.rate.T).T
    up = np.where((T > 5) & (T < 6), np.nan, RUN.up.T).T
    columns = term.columns(replace(RUN, rate=unknown, up=up), None)  # type: ignore[arg-type]
    assert len(columns) == len(term.parameters)
    for column in columns:
        ((channel, state),) = column.items()
        assert np.isfinite(state).all()
        assert np.abs(state).max() <= 1.0
        drive = (RUN.rate if channel < 3 else RUN.force)[:, channel % 3]
        line = np.column_stack([drive, np.ones(len(T))])
        left = state - line @ np.linalg.lstsq(line, state, rcond=None)[0]
        assert left.std() > 0.02 * state.std()


def test_what_never_turned_remembers_nothing():
    assert candidates(recording(), replace(RUN, rate=np.zeros_like(RUN.rate))) == ()
