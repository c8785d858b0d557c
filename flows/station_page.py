"""The page of a station's own computer: how the station stands, and a button that stops it."""

import secrets
import sys
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs

from schemas.base import Unusable
from schemas.recording import RunStatus
from schemas.station import StationFile, Stopped
from storage import settings
from storage.home import Home
from storage.stations import is_dead, lockout_of, read_status, release, status_file_of
from tasks.rendering import BASE, page
from tasks.stages.stop import stop_station

HOST = "127.0.0.1"  # only a person at this computer may press without a login
MOST_BYTES = 1000  # of a form
HEADERS = {
    "Content-Type": "text/html; charset=utf-8",
    "Cache-Control": "no-store",
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; script-src "
    "'unsafe-inline'; connect-src 'self'; form-action 'self'; frame-ancestors 'none'",
}


def serve_page(station: str, port: int, by: str, home: Home) -> None:
    """Serve until Ctrl-C. Raises Unusable where the port is not free."""
    served = StationPage(station, by, home)
    try:
        server = page_server(served, port)
    except OSError as error:
        raise Unusable(
            f"port {port} of {HOST} is not available ({error.strerror}): choose another with --port"
        ) from error
    with server:
        print(f"station {served.id} on http://{HOST}:{server.server_port}; Ctrl-C ends the page")
        sys.stdout.flush()
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print("page ended")


def page_server(served: "StationPage", port: int) -> ThreadingHTTPServer:
    """Raises OSError where the port is not free."""
    return ThreadingHTTPServer((HOST, port), partial(_Handler, served))


class StationPage:
    """What is shown of one station. token: in the form, so that no other site can press it."""

    def __init__(self, station: str, by: str, home: Home) -> None:
        self.id = station
        if Path(station).is_file():
            self.id = settings.read(Path(station), StationFile).station.id
        self.token = secrets.token_urlsafe(16)
        self._station, self._by, self._home = station, by, home
        self.stopped: Stopped | None = None
        self._fault = ""

    def whole(self) -> str:
        """The page."""
        return page(BASE / "station_page.html", station=self.id, **self._now())

    def now(self) -> str:
        """The part of it that changes."""
        return page(BASE / "station_now.html", station=self.id, **self._now())

    def stop(self) -> None:
        """Stop the station; the page then shows what came of it."""
        self.stopped, self._fault = None, ""
        try:
            self.stopped = stop_station(self._station, self._by, self._home)
        except Unusable as fault:
            self._fault = str(fault)

    def release(self) -> None:
        """Let the orders of the station go on; the page then says no more that they wait."""
        self.stopped, self._fault = None, ""
        try:
            release(self.id, self._by, self._home)
        except Unusable as fault:
            self._fault = str(fault)

    def _now(self) -> dict[str, object]:
        status = self._status()
        began = status is not None and self.stopped is not None and status.state != "stopped"
        if began and not self._is_dead(status):
            self.stopped = None  # a run that began since
        return {
            "status": status,
            "is_dead": self._is_dead(status),
            "stopped": self.stopped,
            "fault": self._fault,
            "lockout": lockout_of(self.id, self._home),
            "token": self.token,
        }

    def _status(self) -> RunStatus | None:
        folders = (self._home.station_status, self._home.status)
        found = (read_status(status_file_of(self.id, folder)) for folder in folders)
        return next((each for each in found if each is not None), None)

    def _is_dead(self, status: RunStatus | None) -> bool:
        return status is not None and is_dead(status, self._home)


class _Handler(BaseHTTPRequestHandler):
    def __init__(self, served: StationPage, *given: object) -> None:
        self._served = served
        super().__init__(*given)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        shown = {"/": self._served.whole, "/now": self._served.now}.get(self.path)
        if not self._is_of_this_computer() or shown is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        self._answer(HTTPStatus.OK, shown().encode())

    def do_POST(self) -> None:
        length = int(self.headers.get("Content-Length") or 0)
        form = parse_qs(self.rfile.read(min(length, MOST_BYTES)).decode("utf-8", "replace"))
        token = form.get("token", [""])[0].encode()
        is_own = secrets.compare_digest(token, self._served.token.encode())
        origin = self.headers.get("Origin")
        act = {"/stop": self._served.stop, "/release": self._served.release}.get(self.path)
        if (
            act is None
            or not self._is_of_this_computer()
            or not is_own
            or origin not in (None, f"http://{self.headers['Host']}")
        ):
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        act()
        self.send_response(HTTPStatus.SEE_OTHER)
        self.send_header("Location", "/")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def _is_of_this_computer(self) -> bool:
        """A name that leads here from elsewhere is another site's."""
        name = (self.headers.get("Host") or "").rpartition(":")[0]
        return name in (HOST, "localhost")

    def _answer(self, code: HTTPStatus, content: bytes) -> None:
        self.send_response(code)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        """Prints nothing: each look at the page is a request."""
