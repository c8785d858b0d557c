"""The axes that a client's order names reach the result, the verdict and what is made again."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flows import execute
from schemas.orders import CalibrateOrder, CertifyOrder
from schemas.recording import Recording
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages.estimate import how_made
from tests.own_limits import laboratory_file

PARTY = {"name": "C", "name_zh": "客", "address": "a", "address_zh": "址"}
CODE = "mounting_unknown"


@pytest.mark.usefixtures("unprinted")
def test_an_order_decides_about_which_axes_its_certificate_is(
    home: Path, ideal_run: Callable[..., Recording], tmp_path: Path
) -> None:
    laboratory_file(home)
    place = Home(home)
    run, _ = runs.add(ideal_run(dwell=1.0), place)
    plain = execute.calibrate(CalibrateOrder(run=run.id))
    assert plain.settings["axes"] == "fixture"
    for axes, blocked in (("fixture", False), ("mounting plane", True)):
        order = {"client": PARTY, "received": "2026-05-01", "axes": axes}
        path = tmp_path / "order.json"
        path.write_text(json.dumps(order), encoding="utf-8")
        paper = execute.certify(CertifyOrder(run=run.id, client_order=str(path))).certificate
        made = paper.calibration
        assert made.settings["axes"] == axes
        assert (CODE in {remark.code for remark in made.remarks}) is blocked
        assert how_made(made).axes == axes
    assert len(results.of_run(run, place)) == 2
