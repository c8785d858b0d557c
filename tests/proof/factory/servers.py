"""Processes of the factory's own: `python -m tests.proof.factory.servers KIND PORT …`.

`s3 PORT FOLDER` and `mail PORT FOLDER` keep what they get as files. `station PORT ID SERIAL SEED
SPEED FILE FAULT…` is a virtual station, its unit on the next port. Each serves until it is killed.
"""

import asyncio
import os
import sys
import threading
import time
from collections.abc import Iterator, MutableMapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from aiosmtpd.controller import Controller

from schemas.station import StationFile
from tasks.station.virtual.config import TableDesign, VirtualStation, draw_unit
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import serve
from tests.proof.factory.draw import OUT
from tests.storage.s3_server import Store, serving

BUCKET = "lab/mimu/"


class Files(MutableMapping[str, bytes]):
    """The files of a folder by the keys of their objects."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, key: str) -> Path:
        return self._folder / key.removeprefix(BUCKET)

    def __getitem__(self, key: str) -> bytes:
        try:
            return self._path(key).read_bytes()
        except OSError as error:
            raise KeyError(key) from error

    def __setitem__(self, key: str, data: bytes) -> None:
        self._path(key).parent.mkdir(parents=True, exist_ok=True)
        self._path(key).write_bytes(data)

    def __delitem__(self, key: str) -> None:
        self._path(key).unlink(missing_ok=True)

    def __iter__(self) -> Iterator[str]:
        for path in self._folder.rglob("*"):
            if path.is_file():
                yield BUCKET + path.relative_to(self._folder).as_posix()

    def __len__(self) -> int:
        return sum(1 for _ in self)


class Mails:
    """Each message as a file of the folder, whole before the client hears that it was taken."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    async def handle_DATA(self, _: object, __: object, envelope: Any) -> str:  # noqa: N802
        name = f"{time.time_ns()}.eml"
        draft = self._folder / f".{name}"
        draft.write_bytes(envelope.content)
        os.replace(draft, self._folder / name)
        return "250 OK"


def keep(kind: str, port: int, folder: Path) -> None:
    """Keeps what S3's clients, or senders of mail, give it."""
    if kind == "mail":
        Controller(Mails(folder), hostname="127.0.0.1", port=port).start()
        threading.Event().wait()
    store = Store()
    store.objects = Files(folder)
    with serving(store, port=port):
        threading.Event().wait()


# A virtual station, whose table keeps ten encoder samples a second in place of a hundred: reading
# them is most of what a run costs.

CAPTURE_MS = 100
TOO_LARGE = 1.05  # the limits are ±1.5 %
PRIORITY = -10  # a table has a computer of its own; here it shares the cores with everything else


def station(port: int, id_: str, serial: str, seed: int, speed: float, file: Path,
            faults: list[str]) -> None:  # fmt: skip
    """Serves a station with the unit of that seed, and says in a file how it is reached."""
    unit = draw_unit(seed).model_copy(update={"label": serial})
    if OUT in faults:
        faults.remove(OUT)
        scale = (np.array(unit.gyro.scale) @ np.diag([TOO_LARGE, 1.0, 1.0])).tolist()
        unit = unit.model_copy(update={"gyro": unit.gyro.model_copy(update={"scale": scale})})
    config = VirtualStation(id=id_, table=TableDesign(capture_ms=CAPTURE_MS), unit=unit)
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)

    def ready(made: StationFile) -> None:
        draft = file.with_suffix(".new")
        draft.write_text(made.model_dump_json(indent=1), encoding="utf-8")
        os.replace(draft, file)

    asyncio.run(
        serve(
            config, modbus_port=port, unit_port=port + 1, speed=speed,
            faults=map(StationFault.parse, faults), ready=ready,
        )
    )  # fmt: skip


if __name__ == "__main__":
    kind, port, *more = sys.argv[1:]
    if kind == "station":
        id_, serial, seed, speed, file, *faults = more
        station(int(port), id_, serial, int(seed), float(speed), Path(file), faults)
    else:
        keep(kind, int(port), Path(more[0]))
