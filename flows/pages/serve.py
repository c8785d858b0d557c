"""`mimucal dashboard`: the pages, served until Ctrl-C."""

from ipaddress import ip_address

from flows.pages.app import make_app
from flows.printing import stdout
from schemas.base import Unusable
from storage import settings
from storage.catalogue.users import users
from storage.home import Home

THREADS = 8  # requests answered at the same time; further ones wait


def serve(home: Home, host: str, port: int) -> None:
    """Serve the pages of a home; raises Unusable for an address that cannot be listened on."""
    from waitress.server import create_server

    _check_reach(home, host)
    app = make_app(home)
    try:
        server = create_server(app.server, host=host, port=port, threads=THREADS, ident="mimucal")
    except (OSError, ValueError) as error:
        raise Unusable(
            f"{host} port {port} cannot be listened on ({error}); name others with --host and "
            "--port."
        ) from error
    listening = getattr(server, "effective_port", port)
    stdout(markup=False).print(f"http://{host}:{listening}/ (Ctrl-C ends it)", highlight=False)
    server.run()


def _check_reach(home: Home, host: str) -> None:
    """Raises Unusable for pages that everybody on the network could look at without a name."""
    if host == "localhost" or (_is_address(host) and ip_address(host).is_loopback):
        return
    if not users(home) and settings.pages(home).proxy is None:
        raise Unusable(
            f"--host {host} lets others look at the pages, and nobody has a password yet; "
            "`mimucal user add NAME --role administrator` comes first, or a proxy in "
            f"{home.path / settings.PAGES}."
        )


def _is_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True
