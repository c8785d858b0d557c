"""Stage: the certificates that stand on a finding's runs, and no others."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from schemas.discrepancy import Consequence
from storage.catalogue import certificates, runs
from storage.home import Home
from tasks.review.report import review_of
from tasks.review.search import search
from tasks.review.windows import rows_of
from tasks.stages import review
from tests.drafts import draft
from tests.tasks.review.fleet import fleet, of

MOVED = Consequence(item="gyro_bias", element="x", before=0.25, after=0.3, U=0.02, unit="deg/s")


def test_only_certificates_on_its_runs_are_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    draft(home, "2")
    entries = certificates.register(home)
    chosen = {entry.run: runs.find(entry.run, home) for entry in entries}
    pool = fleet(1, lambda unit, station, day: of("axis_tilt", 2.0 * (station == 2)))
    (one,), p_value = search(pool)
    rows = rows_of(pool, one.best.window)
    names = [run.run for run in pool.runs]
    names[int(np.argmax(rows))] = entries[0].run
    names[int(np.argmin(rows))] = entries[1].run
    renamed = tuple(replace(r, run=n) for r, n in zip(pool.runs, names, strict=True))
    one = replace(one, pool=replace(pool, runs=renamed))
    monkeypatch.setattr(review, "moved_elements", lambda recording, effect, values, limits: [MOVED])
    completed = review.with_certificates(review_of(pool, (one,), p_value), (one,), chosen, home)
    (found,) = completed.findings[0].touched
    assert (found.certificate, found.in_U) == (entries[0].number, pytest.approx(2.5))
