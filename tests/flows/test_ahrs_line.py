"""JJF 1536 as a whole: the demonstration's line, and station and acquisition by themselves."""

import json
import os
import subprocess
import sys
from datetime import date
from pathlib import Path

import pytest

from schemas.procedure import Procedure
from tasks.station import procedures

pytestmark = pytest.mark.real_time


@pytest.fixture
def short(tmp_path) -> Path:
    """JJF 1536 of the program in seconds."""
    whole = procedures.load("jjf1536").model_dump(mode="json")
    for step in whole["steps"]:
        if "dwell_s" in step:
            step["dwell_s"] = 4.0
        if step["kind"] == "rate_run":
            step["rates_deg_s"] = [-200.0, -50.0, 50.0, 200.0]
        if step["kind"] == "turns":
            step["turns"] = 3
    content = Procedure.model_validate(whole | {"name": "short1536", "warm_up_s": 5.0})
    path = tmp_path / "short1536.json"
    path.write_text(content.model_dump_json(), encoding="utf-8")
    return path


def mimucal(
    home: Path, *arguments: object, server: str | None = None
) -> subprocess.CompletedProcess[str]:
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    return subprocess.run(
        [sys.executable, "-m", "flows.cli", *map(str, arguments)],
        capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL,
        env=keep | {"MIMUCAL_HOME": str(home)} | ({"PREFECT_API_URL": server} if server else {}),
    )  # fmt: skip


@pytest.mark.rehearsal
def test_one_command_leads_from_the_station_to_the_certificate(
    home, short, validated, prefect_server
):
    home.mkdir()
    (home / "validation.json").write_text(validated.model_dump_json(), encoding="utf-8")
    done = mimucal(home, "demo", "--procedure", short, "--speed", 200, "--json",
                   server=prefect_server)  # fmt: skip
    assert done.returncode == 0, done.stderr
    made = json.loads(done.stdout)
    assert made["verdict"] == "inconclusive"  # seconds are no 20 s
    today = date.today()
    due = date.fromisoformat(made["due"])
    assert (due.year, due.month) == (today.year + 2, today.month)
    assert made["reminders"] == [{"unit": "Virtual V-AHRS A00001", "due": made["due"]}]
    for name in ("raw", "columns", "certificate", "record", "truth"):
        assert Path(made["paths"][name]).exists()
    record = json.loads(Path(made["paths"]["record"]).read_text(encoding="utf-8"))
    items = record["calibration"]["items"]
    assert list(items) == ["ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"]
    truth = json.loads(Path(made["paths"]["truth"]).read_text(encoding="utf-8"))
    for axis, true in zip("xyz", truth["K"], strict=True):
        assert items["ahrs_scale_factor"]["value"][axis] == pytest.approx(true, abs=2e-5)
    decided = {limit["item"]: limit["verdict"] for limit in record["decision"]["limits"]}
    assert set(decided.values()) == {"pass"}
