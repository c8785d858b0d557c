"""`mimucal dashboard`: the pages, served until Ctrl-C."""

from flows.pages.app import make_app
from flows.printing import stdout
from schemas.base import Unusable
from storage.home import Home

THREADS = 8  # requests answered at the same time; further ones wait


def serve(home: Home, host: str, port: int) -> None:
    """Serve the pages of a home; raises Unusable for an address that cannot be listened on."""
    from waitress.server import create_server

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
