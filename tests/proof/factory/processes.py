"""The processes of the factory: begun, waited for, killed and started again; none survives it."""

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import psutil

START_S = 180.0  # with every core busy
END_S = 20.0
LOOK_S = 0.1
RESTART_S = 5.0  # after which the unit files of the guide start a service again (RestartSec=)


class NotUpError(RuntimeError):
    """A part ended at its start, or did not answer."""


@dataclass
class Part:
    """One process, with what it prints in a log.

    answers: whether it does what it is for. is_service: whether the computer's service manager
    starts it again where it ends by itself (Restart=always). Processes that it started are its own
    affair, as they are where a service manager keeps them: a kill is of this process alone.
    """

    name: str
    command: Sequence[object]
    variables: Mapping[str, str]
    logs: Path
    answers: Callable[[], bool] = lambda: True
    is_service: bool = False
    processor_s: float = field(default=0.0, init=False)  # of it and what it waited for, once ended
    _process: "subprocess.Popen[bytes] | None" = field(default=None, init=False)
    _ended_s: float | None = field(default=None, init=False)

    def begin(self) -> None:
        """Start the process without waiting for it; its standard input ends with this process."""
        self.logs.mkdir(parents=True, exist_ok=True)
        with (self.logs / f"{self.name}.log").open("ab") as log:
            self._process = subprocess.Popen(
                list(map(str, self.command)), env=dict(self.variables), stdin=subprocess.PIPE,
                stdout=log, stderr=log, start_new_session=True,
            )  # fmt: skip

    def wait(self) -> None:
        """Wait until it answers; raises NotUpError where it does not."""
        end_s = time.monotonic() + START_S
        while not self.answers():
            if self._process is None or self._process.poll() is not None:
                raise NotUpError(f"{self.name} ended at its start: see {self.logs / self.name}.log")
            if time.monotonic() > end_s:
                raise NotUpError(f"{self.name} did not answer: see {self.logs / self.name}.log")
            time.sleep(LOOK_S)

    def start(self) -> None:
        """Start the process, and wait until it answers."""
        self.begin()
        self.wait()

    def kill(self) -> None:
        """SIGKILL."""
        if self._process is not None:
            self._count()
            self._process.kill()
            self._process.wait(END_S)

    def _count(self) -> None:
        """Add the processor time of the process and of its children that ended."""
        try:
            assert self._process is not None
            self.processor_s += sum(psutil.Process(self._process.pid).cpu_times()[:4])
        except psutil.Error:
            return

    def keep_up(self) -> None:
        """Start a service that ended by itself again, as late as a service manager does."""
        if not self.is_service or self._process is None or self.is_up:
            self._ended_s = None
            return
        self._ended_s = self._ended_s or time.monotonic()
        if time.monotonic() >= self._ended_s + RESTART_S:
            self._ended_s = None
            self.begin()

    @property
    def is_up(self) -> bool:
        """Whether its process lives."""
        return self._process is not None and self._process.poll() is None

    def end(self) -> None:
        """Have it end as its service manager would, with what it started.

        Of one that ended before, nothing is looked for: its number may be another program's by now.
        """
        if self._process is None or not self.is_up:
            self._process = None
            return
        began = _of_group(self._process.pid)
        self._count()
        self._process.terminate()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(END_S)
        for left in began:
            if left.is_running():
                left.kill()
        self._process = None


def _of_group(leader: int) -> list[psutil.Process]:
    """The living processes of a session but its leader."""
    found = []
    for each in psutil.process_iter():
        try:
            if each.pid != leader and os.getsid(each.pid) == leader:
                found.append(each)
        except (ProcessLookupError, psutil.Error):
            continue
    return found


def end_all(processes: Sequence[psutil.Process]) -> None:
    """SIGKILL whatever still lives of them."""
    for each in processes:
        try:
            each.send_signal(signal.SIGKILL)
        except psutil.Error:
            continue
    psutil.wait_procs(processes, END_S)


# Nothing of a play survives it, however it ends.
#
# The play is a process of its own. This one adopts whatever of it loses its parent, waits, and ends
# what is left; it ends the play where it is itself ended.

_SET_DEATH_SIGNAL, _SET_SUBREAPER = 1, 36  # of prctl(2)
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def guarded(play: Callable[[], int]) -> int:
    """What the play answers, once nothing is left of it."""
    adopt()
    guard = os.getpid()
    child = os.fork()
    if child == 0:
        _play(guard, play)
    for each in STOPPING:  # a terminal's Ctrl-C reaches the play by itself
        signal.signal(each, lambda number, _: _pass_on(child, number))
    _, status = os.waitpid(child, 0)
    end_all(left())
    return os.waitstatus_to_exitcode(status)


def adopt() -> None:
    """From now on, processes below this one that lose their parent become its own."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_SUBREAPER, 1)


def left() -> list[psutil.Process]:
    """What lives below this process."""
    alive = []
    for each in psutil.Process().children(recursive=True):
        try:
            if each.status() != psutil.STATUS_ZOMBIE:
                alive.append(each)
        except psutil.Error:
            continue
    return alive


def _pass_on(child: int, number: int) -> None:
    if number != signal.SIGINT:
        os.kill(child, number)


def _play(guard: int, play: Callable[[], int]) -> NoReturn:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGTERM)
    signal.signal(signal.SIGTERM, _interrupt)
    signal.signal(signal.SIGHUP, _interrupt)
    code = 1
    try:
        if os.getppid() == guard:
            code = play()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt
