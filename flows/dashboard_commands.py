"""`mimucal dashboard`, which serves the operations pages."""

import typer

from flows import options

app = typer.Typer()


@app.command(epilog="Example: mimucal dashboard --port 8765")
def dashboard(host: options.Host = "127.0.0.1", port: options.PagesPort = 8765) -> None:
    """Serve the operations pages until Ctrl-C.

    Line, runs, units, quality, mismatch and due dates, in Chinese and English.
    """
    from flows.pages.serve import serve
    from storage.home import home

    serve(home(), host, port)
