"""Homes with stations for tests of orders, and a worker that only notes that it was begun."""

import json
import subprocess
from pathlib import Path
from typing import Any

from tests.tasks.station.sample_stations import sample

CLIENT = """
format = "mimu-order/1"
received = 2026-01-08
interval_months = 12
[client]
name = "Client"
name_zh = "客户"
address = "Street"
address_zh = "街"
"""


def add_station(home: Path, station: str = "LINE-1", **changes: Any) -> Path:
    """A station file of the home; station_part: of its entry `station` what is other."""
    fields = sample()
    changes["station"] = fields["station"] | {"id": station} | changes.get("station_part", {})
    changes.pop("station_part", None)
    file = home / "stations" / f"{station}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(fields | changes), encoding="utf-8")
    return file


class Begun:
    """In the place of a process: the commands that were begun."""

    def __init__(self) -> None:
        self.commands: list[list[str]] = []

    def __call__(self, command: list[str], **_: Any) -> "Begun":
        self.commands.append(command)
        return self

    def poll(self) -> int:
        return 0


def no_workers(monkeypatch: Any) -> Begun:
    begun = Begun()
    monkeypatch.setattr(subprocess, "Popen", begun)
    return begun
