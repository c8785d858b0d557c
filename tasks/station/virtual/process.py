"""The virtual station in a process of its own, for demonstrations and tests.

`python -m tasks.station.virtual.process CONFIG SPEED FAULT...` writes the station file as one line
of JSON, and ends when standard input closes.
"""

import asyncio
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault

END_S = 5.0


@contextmanager
def running(
    config: VirtualStation, speed: float, faults: Iterable[StationFault] = ()
) -> Iterator[StationFile]:
    """A running station; it ends with the block, or with this process.

    speed: station seconds in a wall second. Raises Unusable with the station's own sentence where
    it cannot start.
    """
    with subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            __name__,
            config.model_dump_json(),
            str(speed),
            *map(str, faults),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for this process, which then ends the station
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            answer = process.stdout.readline()
            if not answer.startswith("{"):
                raise Unusable(
                    answer.strip() or "the virtual station did not start: see its messages"
                )
            yield StationFile.model_validate_json(answer)
        finally:
            process.stdin.close()
            try:
                process.wait(END_S)
            except subprocess.TimeoutExpired:
                process.kill()


async def _serve_until_input_ends(config: str, speed: str, *faults: str) -> None:
    from tasks.station.virtual.servers import serve

    serving = asyncio.ensure_future(
        serve(
            VirtualStation.model_validate_json(config),
            speed=float(speed),
            faults=[StationFault.parse(text) for text in faults],
            ready=lambda station: print(station.model_dump_json(), flush=True),
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
    asyncio.run(_serve_until_input_ends(*sys.argv[1:]))
