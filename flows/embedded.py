"""The Prefect server that a command starts for itself: it outlives no command and hears no Ctrl-C.

Prefect 3.8 starts it in the command's own process group, where Ctrl-C ends it before the command
has told it how its flow ended, and leaves it behind when the command is killed.

Import this module only after `flows.server.prepare`.
"""

import atexit
import ctypes
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from prefect.server.api import server as prefect_server

LOG = "server.log"
_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)


def start(folder: Path) -> None:
    """Start the server in a session of its own; what it says goes to a log file in the folder.

    To be called from the main thread: Linux ends the server with the thread that started it.
    """

    def started(args: list[str], env: dict[str, str]) -> "subprocess.Popen[bytes]":
        with (folder / LOG).open("ab") as log:
            return subprocess.Popen(
                args, env=env, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                start_new_session=True, preexec_fn=_DIE_WITH_PARENT,
            )  # fmt: skip

    own: Any = SimpleNamespace(Popen=started, TimeoutExpired=subprocess.TimeoutExpired)
    prefect_server.subprocess = own
    prefect_server.SubprocessASGIServer().start()
    # Runs before the server's own end, which a second Ctrl-C would break off with a traceback.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def _die_with_parent() -> Any:
    """What a child does between fork and exec; the library is opened before the fork."""
    prctl = ctypes.CDLL(None).prctl
    return lambda: prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)


_DIE_WITH_PARENT = _die_with_parent() if sys.platform == "linux" else None
