"""The virtual station in a process of its own, for demonstrations and tests.

`python -m tasks.station.virtual.process` reads its settings as JSON on one line of standard
input, writes the station file as one line, and ends when standard input closes.
"""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.virtual.config import VirtualStation, truth
from tasks.station.virtual.faults import Fault

ROOT = Path(__file__).parents[3]
END_S = 5.0


@contextmanager
def running(
    config: VirtualStation,
    speed: float,
    faults: Iterable[Fault] = (),
    truth_path: Path | None = None,
) -> Iterator[StationFile]:
    """A running station; it ends with the block, or with this process.

    speed: station seconds in a wall second. truth_path: where the truth is written as JSON.
    Raises Unusable with the station's own sentence where it cannot start.
    """
    if truth_path is not None:
        truth_path.write_text(json.dumps(truth(config), indent=1) + "\n", encoding="utf-8")
    settings = {
        "config": config.model_dump(mode="json"),
        "speed": speed,
        "faults": [str(fault) for fault in faults],
    }
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, "-m", "tasks.station.virtual.process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for this process, which then ends the station
        env={**os.environ, "PYTHONPATH": path},
    )
    try:
        yield _start(process, json.dumps(settings))
    finally:
        _end(process)


def _start(process: "subprocess.Popen[str]", settings: str) -> StationFile:
    assert process.stdin is not None
    assert process.stdout is not None
    with suppress(BrokenPipeError):
        process.stdin.write(settings + "\n")
        process.stdin.flush()
    answer = process.stdout.readline()
    if not answer.startswith("{"):
        raise Unusable(answer.strip() or "the virtual station did not start: see its messages")
    return StationFile.model_validate_json(answer)


def _end(process: "subprocess.Popen[str]") -> None:
    with suppress(BrokenPipeError):
        process.stdin.close()  # type: ignore[union-attr]
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()  # type: ignore[union-attr]


def _print(station: StationFile) -> None:
    print(station.model_dump_json(), flush=True)


async def _serve_until_input_ends(settings: str) -> None:
    from tasks.station.virtual.servers import serve

    values = json.loads(settings)
    serving = asyncio.ensure_future(
        serve(
            VirtualStation.model_validate(values["config"]),
            speed=values["speed"],
            faults=[Fault.parse(text) for text in values["faults"]],
            ready=_print,
        )
    )
    input_ended = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    await asyncio.wait((serving, input_ended), return_when=asyncio.FIRST_COMPLETED)
    if serving.done():
        try:
            serving.result()
        except Unusable as error:
            print(error, flush=True)
    serving.cancel()


if __name__ == "__main__":
    asyncio.run(_serve_until_input_ends(sys.stdin.readline()))
