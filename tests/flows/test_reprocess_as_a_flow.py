"""Re-processing as a flow run on a Prefect server that is named, and on one that is not there."""

import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.earlier_results import newest, plant, two_calibrated

pytestmark = pytest.mark.real_time


def reprocessed(home: Path, server: str) -> tuple[dict[str, Any], str]:
    """What the command reports with that server named, and what it says beside."""
    others = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    done = subprocess.run(
        [sys.executable, "-m", "flows.cli", "reprocess", "--workers", "2", "--json"],
        capture_output=True, text=True, timeout=600,
        env=others | {"MIMUCAL_HOME": str(home), "PREFECT_API_URL": server},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


def test_its_processes_make_the_same_results(home, mimucal, ideal_run, prefect_server) -> None:
    store = two_calibrated(home, mimucal, ideal_run)
    first, second = newest(store)
    plant(first, store, "gyro_scale_factor", "x", 3.0)
    plant(second, store, "gyro_scale_factor", "y", 2.0)
    report, _ = reprocessed(home, prefect_server)
    moved = {(each["run"], each["element"]) for each in report["changed"]}
    assert moved == {(first.run, "x"), (second.run, "y")}
    assert newest(store) == [first, second]


def test_a_server_that_is_not_there_costs_the_record_and_nothing_else(
    home, mimucal, ideal_run
) -> None:
    store = two_calibrated(home, mimucal, ideal_run)
    first, _ = newest(store)
    plant(first, store, "gyro_scale_factor", "x", 3.0)
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))  # nobody else listens there, and this does not
        report, errors = reprocessed(home, f"http://127.0.0.1:{nobody.getsockname()[1]}/api")
    assert [each["run"] for each in report["changed"]] == [first.run]
    assert "Warning" not in errors
