"""A command with everything beside it: how long it takes, processor time, memory."""

import os
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import count

import psutil

EVERY_S = 1.0
MEMORY_EVERY = 4  # looks: counting the pages of ten processes takes a twentieth of a second
MIMUCAL = (sys.executable, "-c", "from flows.cli import main; main()")
OWN = "prefect-server"  # name of the server's process that a command forks for itself
KEPT = ["-m", "prefect", "server", "start"]  # command line of one that stands
Name = tuple[int, float]  # process id, and when it began
Used = tuple[float, bool]  # processor time, and whether it is Prefect's server


@dataclass(frozen=True)
class Watched:
    """What a command printed, and what it cost with all that this process started.

    processor_s: of them all meanwhile; prefect_s: of Prefect's server among them; command_s: of the
    command and what it started, to the end of each; memory: the most bytes at one moment, pages
    that processes share counted once.
    """

    out: str
    wall_s: float
    processor_s: float
    prefect_s: float
    command_s: float
    memory: int


def environment(**changes: str) -> dict[str, str]:
    """Of a process that is measured: no settings of others, one thread for linear algebra, and
    byte code kept as it is for a user.
    """
    others = ("PREFECT_", "MIMUCAL_", "PYTHONDONTWRITEBYTECODE")
    kept = {k: v for k, v in os.environ.items() if not k.startswith(others)}
    return kept | {"OPENBLAS_NUM_THREADS": "1", "AWS_EC2_METADATA_DISABLED": "true"} | changes


def watched(
    command: Sequence[str],
    variables: Mapping[str, str],
    meanwhile: Callable[[], None] = lambda: None,
    every_s: float = EVERY_S,
) -> Watched:
    """Runs a command; raises RuntimeError with what it said where it fails.

    meanwhile: called at every look, every_s apart. What a process does after the last look is
    missing in processor_s and prefect_s, not in command_s.
    """
    began, ended, before = time.perf_counter(), _of_ended(), dict[Name, Used]()
    _look(before)
    process = subprocess.Popen(
        command, env=dict(variables), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    used, memory, looks = dict(before), 0, count()
    response: list[str] = []
    reader = threading.Thread(target=lambda: response.extend(process.communicate()))
    reader.start()
    while reader.is_alive():
        _look(used)
        if next(looks) % MEMORY_EVERY == 0:
            memory = max(memory, _memory())
        meanwhile()
        reader.join(every_s)
    if process.returncode:
        raise RuntimeError(response[1])
    own = [
        (seconds - before.get(name, (0.0, False))[0], of_server)
        for name, (seconds, of_server) in used.items()
    ]
    return Watched(
        out=response[0],
        wall_s=time.perf_counter() - began,
        processor_s=sum(seconds for seconds, _ in own),
        prefect_s=sum(seconds for seconds, of_server in own if of_server),
        command_s=_of_ended() - ended,
        memory=memory,
    )


def _of_ended() -> float:
    """Processor time of the children of this process that have ended, and of theirs."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _look(used: dict[Name, Used]) -> None:
    """Notes the processor time of each process so far."""
    for each in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            times = each.cpu_times()
            name = (each.pid, each.create_time())
            # One that has just ended has no command line any more.
            of_server = used.get(name, (0.0, False))[1] or _is_server(each)
            used[name] = (times.user + times.system, of_server)


def _is_server(process: psutil.Process) -> bool:
    """Whether a process is Prefect's server."""
    words = process.cmdline()
    kept = any(words[first : first + len(KEPT)] == KEPT for first in range(len(words)))
    return kept or process.name() == OWN


def _memory() -> int:
    """Bytes of all processes together."""
    memory = 0
    for each in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            memory += each.memory_full_info().pss
    return memory
