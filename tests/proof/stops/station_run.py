"""A run and a virtual station in processes of their own, forked: they begin at once."""

import asyncio
import importlib
import os
import signal
import sys
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any
from unittest.mock import patch

from schemas.base import BrokenOff, Unusable
from schemas.orders import AcquireOrder
from schemas.station import StationFile
from tasks.station.sequencer import Sequencer
from tasks.station.virtual.config import VirtualStation

HANG_S = 6.0
HANGS = "hangs"  # a file in the station's folder, from whose appearing on the run's loop stands


IMPORTED = (
    "flows.acquisition_view", "tasks.stages.acquire", "tasks.station.virtual.servers",
    "pymodbus.client", "serial", "storage.catalogue.runs", "alembic.command", "fluent.runtime",
    "tasks.rendering.page", "jinja2",
)  # fmt: skip


def preload() -> None:
    """Import once what every fork needs."""
    for name in IMPORTED:
        importlib.import_module(name)


@contextmanager
def station_apart(config: VirtualStation, speed: float) -> Iterator[StationFile]:
    """A running virtual station."""
    context = get_context("fork")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(config, speed, there), daemon=True)
    process.start()
    try:
        yield here.recv()
    finally:
        process.kill()
        process.join()


def _serve(config: VirtualStation, speed: float, ready: Any) -> None:
    from tasks.station.virtual.servers import serve

    asyncio.run(serve(config, speed=speed, ready=ready.send))


def begin(folder: Path, environment: dict[str, str], resume: bool = False) -> BaseProcess:
    """An acquisition by folder/station.json and folder/procedure.json."""
    process = get_context("fork").Process(target=_acquire, args=(folder, environment, resume))
    process.start()
    return process


def _acquire(folder: Path, environment: dict[str, str], resume: bool) -> None:
    from flows import run_orders

    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(each, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.update(environment)
    order = AcquireOrder(
        station=str(folder / "station.json"), procedure=str(folder / "procedure.json"),
        attended=False, resume=resume,
    )  # fmt: skip
    with (folder / "run.log").open("a") as log, patch.object(Sequencer, "_watch", _hanging(folder)):
        sys.stderr = sys.stdout = log
        try:
            run_orders.acquire(order)
        except (BrokenOff, Unusable) as end:
            log.write(f"{end}\n")
            log.flush()
            os._exit(1)
        except KeyboardInterrupt:
            log.write("Ctrl-C\n")
            log.flush()
            os._exit(1)
        log.flush()
    os._exit(0)


def _hanging(folder: Path) -> Callable[[Sequencer], Coroutine[Any, Any, Any]]:
    """The look at the table, which hangs once where the folder says so."""
    watch = Sequencer._watch

    async def look(self: Sequencer) -> Any:
        with suppress(FileNotFoundError):
            (folder / HANGS).unlink()
            (folder / f"{HANGS}-now").touch()
            time.sleep(HANG_S)
        return await watch(self)

    return look
