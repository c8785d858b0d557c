"""The Prefect server: the one PREFECT_API_URL names, or one that a command starts for itself.

A command's own server keeps its database in the home, outlives no command and ignores Ctrl-C.
Prefect's temporary server would not do: it runs in the command's process group, where Ctrl-C ends
it before the command has reported how its flow ended, and a killed command leaves it behind.
"""

import atexit
import ctypes
import gc
import os
import secrets
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import monotonic
from types import FrameType
from typing import IO, TYPE_CHECKING

from pydantic import ValidationError

from schemas.base import Unusable
from storage.home import Home, environment
from storage.whole_files import make_folder
from tasks.stages.prefect_api import CLIENT_AUTH, SERVER_AUTH, is_refusal
from tasks.words import message

if TYPE_CHECKING:
    from prefect.client.orchestration import SyncPrefectClient
    from starlette.types import ASGIApp, Message, Receive, Scope, Send


LOG = "server.log"
START_UP_S = 600.0  # with all cores busy it takes minutes; a server that ends is noticed at once
TERMINATION_S = 5.0
BUSY_S = 600.0  # how long a server that only answers “busy” is asked again
BUSY = 503
STOPPING = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT}  # meant for the command
END = signal.SIGUSR1  # by which the command ends its server
_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)

# What is set here must be in the environment before Prefect is imported for the first time.
QUIET = {
    # The sentence of Unusable is for us to print; a server of one's own still gets the logs.
    "PREFECT_LOGGING_HANDLERS_CONSOLE_LEVEL": "CRITICAL",
    "PREFECT_INTERNAL_LOGGING_LEVEL": "CRITICAL",
    "DO_NOT_TRACK": "1",
    "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
    "PREFECT_CLI_WRAP_LINES": "false",
}
OWN_SERVER = {
    "PREFECT_LOGGING_LEVEL": "CRITICAL",
    "PREFECT_LOGGING_TO_API_ENABLED": "false",
    # A server that does not answer has ended: a minute's retries of each report would hang the run.
    # One that answers “busy” is retried all the same: `asked_again_when_busy`.
    "PREFECT_CLIENT_MAX_RETRIES": "0",
    # We use no blocks; registering them is a sixth of the server's start.
    "PREFECT_API_BLOCKS_REGISTER_ON_START": "false",
    # Nor automations; their triggers and actions are a third of what an idle server does.
    "PREFECT_SERVER_SERVICES_TRIGGERS_ENABLED": "false",
}


def server_named() -> bool:
    """Whether the operator named a Prefect server; every order is then a flow run on it."""
    return environment().prefect_server is not None


def connect(home: Home, meanwhile: Callable[[], None] = lambda: None) -> None:
    """Point Prefect at its server before it is imported; start one if none is named.

    Environment variables set by the operator are kept. Call this from the main thread: Linux ends
    the server together with the thread that started it. meanwhile: done while the server starts.
    """
    settings = QUIET if server_named() else QUIET | OWN_SERVER
    for name, value in settings.items():
        os.environ.setdefault(name, value)
    if server_named():  # Prefect prints the URL: the login does not stay in it
        named = environment()
        os.environ["PREFECT_API_URL"] = str(named.prefect_server)
        if named.prefect_login:
            os.environ[CLIENT_AUTH] = named.prefect_login
    else:
        _start(home.prefect.absolute(), meanwhile)
        # Runs before the server is ended, which a second Ctrl-C would break off with a traceback.
        for stop in STOPPING:
            atexit.register(signal.signal, stop, signal.SIG_IGN)


def _start(folder: Path, meanwhile: Callable[[], None]) -> None:
    """Start a server whose database is in the folder, and wait until it answers."""
    try:
        make_folder(folder)
        log = (folder / LOG).open("ab")
    except OSError as error:
        raise Unusable(
            f"{folder} cannot be written ({error.strerror}), which Prefect's server needs; give "
            "rights there, name another folder in MIMUCAL_HOME, or set PREFECT_API_URL to a server "
            "that runs"
        ) from error
    os.environ.setdefault("PREFECT_HOME", str(folder))
    with log, socket.create_server(("127.0.0.1", 0)) as listener:
        url = f"http://127.0.0.1:{listener.getsockname()[1]}/api"
        os.environ["PREFECT_API_URL"] = url
        # Nobody else on this machine orders anything: only this process and its children know it.
        os.environ[CLIENT_AUTH] = os.environ[SERVER_AUTH] = f"mimucal:{secrets.token_hex(16)}"
        _import_prefect()  # before the fork: both need it
        _fork(listener, log)
    import httpx

    meanwhile()
    try:  # the socket listens already: the answer comes once the server is there
        httpx.get(f"{url}/health", timeout=START_UP_S, trust_env=False).raise_for_status()
    except httpx.HTTPError as error:
        raise Unusable(
            f"Prefect's server did not start (see {folder / LOG}); close other programs, make room "
            "on its disk, or set PREFECT_API_URL to a server that runs"
        ) from error


def _import_prefect() -> None:
    """Import it with its settings, which the variables PREFECT_... of the operator set."""
    try:
        from prefect.settings import get_current_settings

        get_current_settings()
    except ValidationError as error:
        first = error.errors()[0]
        raise Unusable(
            f"Prefect's setting {'.'.join(map(str, first['loc']))} is {first['input']!r}, which "
            f"cannot be used ({first['msg']}); mend or remove the variable PREFECT_... that sets it"
        ) from error


def _fork(listener: socket.socket, log: IO[bytes]) -> None:
    """Start the server, and see that it ends with this process; no signal falls in between."""
    server = get_context("fork").Process(target=_serve_apart, args=(os.getpid(), listener, log))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        server.start()
        atexit.register(_end, server)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end(server: BaseProcess) -> None:
    if server.pid and server.is_alive():
        os.kill(server.pid, END)
    server.join(TERMINATION_S)
    if server.is_alive():
        server.kill()
        server.join()


def _serve_apart(parent: int, listener: socket.socket, log: IO[bytes]) -> None:
    """In a fork of the command, with a session and a log of its own.

    A signal sent to every process of the command line, as by `pkill -f`, is meant for the command,
    which reports its end to this server: such signals stay blocked until END comes.
    """
    os.setsid()
    for stop in STOPPING:
        signal.signal(stop, signal.SIG_DFL)
    signal.signal(END, _stop_now)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:  # it died before
        return
    for number in (1, 2):
        os.dup2(log.fileno(), number)
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)
    # Those of the command draw its progress, perhaps in a thread that the fork left behind.
    sys.stdout = sys.stderr = os.fdopen(2, "w", buffering=1)
    serve(listener)


def _stop_now(_: int, __: FrameType | None) -> None:
    """Lets the server end as it does by itself."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    signal.raise_signal(signal.SIGTERM)


def asked_again_when_busy(app: "ASGIApp", clock: Callable[[], float] = monotonic) -> "ASGIApp":
    """The server's app, whose client asks again a second after an answer of “busy” (503).

    Prefect's server answers so where two of its transactions met in SQLite; its client asks again,
    without counting, where the answer has these headers (prefect 3.8, `_send_with_retry`).
    """
    answered = clock()

    async def answer(scope: "Scope", receive: "Receive", send: "Send") -> None:
        async def send_on(message: "Message") -> None:
            nonlocal answered
            if message["type"] == "http.response.start":
                if message["status"] != BUSY:
                    answered = clock()
                elif clock() - answered < BUSY_S:
                    again = [(b"prefect-maintenance", b"true"), (b"retry-after", b"1")]
                    message = {**message, "headers": [*message["headers"], *again]}
            await send(message)

        await app(scope, receive, send_on)

    return answer


def serve(listener: socket.socket) -> None:
    """Run the server on a listening socket."""
    gc.disable()  # collecting is 0.6 s of 5.7 s of these imports, which make no garbage
    import uvicorn
    from prefect.server.api.server import create_app

    app = asked_again_when_busy(create_app(ephemeral=True, final=True))
    gc.freeze()
    gc.enable()
    uvicorn.Server(uvicorn.Config(app, log_level="error")).run(sockets=[listener])


# The client of the Prefect server that PREFECT_API_URL names.


@contextmanager
def prefect_client(otherwise: str) -> "Iterator[SyncPrefectClient]":
    """A client of the server; what it refuses or does not answer raises Unusable.

    otherwise: the end of that sentence. Call `flows.on_prefect.server.connect` before.
    """
    from httpx import HTTPError
    from prefect.client.orchestration import get_client

    try:
        with get_client(sync_client=True) as client:
            yield client
    except (HTTPError, RuntimeError) as error:  # the latter where it cannot be reached
        why = (
            f"refused {CLIENT_AUTH}: set it to the server's {SERVER_AUTH}"
            if is_refusal(error)
            else f"did not answer ({error}): start it, or mend PREFECT_API_URL"
        )
        raise Unusable(
            f"Prefect's server {environment().prefect_server} {why}; {otherwise}",
            message("station-cause.no-server"),
        ) from error
