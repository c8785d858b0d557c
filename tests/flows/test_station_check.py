"""`mimucal station check` on a station that nobody answers for."""

import json
from pathlib import Path

import pytest

from flows import station as commands
from tests.tasks.station.sample_stations import sample


@pytest.mark.real_time
def test_every_device_that_does_not_work_is_said_and_the_command_fails(
    tmp_path, monkeypatch, capsys
):
    import typer

    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "home"))
    fields = sample("mimucal")
    for device in ("table", "chamber", "fixture", "unit_link"):
        fields[device]["url"] = "socket://127.0.0.1:1"
    file = Path(tmp_path / "station.json")
    file.write_text(json.dumps(fields), encoding="utf-8")
    with pytest.raises(typer.Exit) as end:
        commands.check(str(file), move=False, as_json=True)
    assert end.value.exit_code == 1
    checked = json.loads(capsys.readouterr().out)
    assert checked["format"] == "mimu-station-check/1"
    failed = {(trial["device"], trial["works"]) for trial in checked["trials"]}
    assert failed == {(name, False) for name in ("table", "chamber", "fixture", "unit")}
