"""`mimucal dashboard`: serves the pages until Ctrl-C."""

import gc
import logging
from ipaddress import ip_address
from typing import Any

from waitress.server import create_server

from flows.logs import set_up
from flows.pages.app import make_app
from flows.printing import stdout
from schemas.base import Unusable
from storage import settings
from storage.catalogue.users import users
from storage.home import Home

HERE = ("127.0.0.1", "localhost", "[::1]")
THREADS = 8  # requests answered at the same time; further ones wait


def serve(home: Home, host: str, port: int) -> None:
    """Serve the pages of a home; raises Unusable for an address that cannot be listened on."""
    set_up(errors_at_least=True)
    server = listening(home, host, port)
    stdout(markup=False).print(
        f"http://{host}:{server.effective_port}/ (Ctrl-C ends it)", highlight=False
    )
    server.run()


def listening(home: Home, host: str, port: int) -> Any:
    """A server of the pages that listens already; `run` answers, `close` ends it."""
    _check_reach(home, host)
    app = make_app(home).server
    gc.freeze()  # what was imported lives to the end: no collection walks over it again
    pages = settings.pages(home)
    if _is_here(host) and pages.proxy is None and not pages.https:
        # A page of another host whose name leads here must not read what is open on this machine.
        app.config["TRUSTED_HOSTS"] = list(HERE)
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # that somebody waits is no fault
    try:
        return create_server(
            app, host=host, port=port, threads=THREADS, ident="mimucal",
            clear_untrusted_proxy_headers=False,  # by them health.py sees who comes from elsewhere
        )  # fmt: skip
    except (OSError, ValueError) as error:
        raise Unusable(
            f"the pages cannot be served at {host} port {port} ({error}); choose others with "
            "--host and --port."
        ) from error


def _check_reach(home: Home, host: str) -> None:
    """Raises Unusable for pages that everybody on the network could look at without a name."""
    if not _is_here(host) and not users(home) and settings.pages(home).proxy is None:
        raise Unusable(
            f"--host {host} opens the pages to other computers, but nobody has a password yet; "
            "first run `mimucal user add NAME --role administrator`, or name a proxy in "
            f"{home.path / settings.PAGES}."
        )


def _is_here(host: str) -> bool:
    """Whether an address is reached from this machine alone."""
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False
