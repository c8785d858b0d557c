"""What is said of a Prefect server that refuses the password."""

from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest
from prefect.settings import PREFECT_API_URL, temporary_settings

from flows.on_prefect import queue
from flows.on_prefect.deployments import deploy_line
from schemas.base import Unusable
from storage.home import Home

pytestmark = pytest.mark.real_time
REFUSED = "refused PREFECT_API_AUTH_STRING: set it to the server's PREFECT_SERVER_API_AUTH_STRING"


class Refusing(BaseHTTPRequestHandler):
    """Answers every question as Prefect's server does one with a wrong password."""

    def do_GET(self) -> None:
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.send_response(401)
        self.end_headers()
        self.wfile.write(b'{"exception_message": "Unauthorized"}')

    do_POST = do_GET  # noqa: N815 (the name is that of http.server)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def url(monkeypatch) -> Iterator[str]:
    with HTTPServer(("127.0.0.1", 0), Refusing) as server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        url = f"http://127.0.0.1:{server.server_port}/api"
        monkeypatch.setenv("PREFECT_API_URL", url)
        monkeypatch.setattr(queue, "connect", lambda _: None)
        with temporary_settings({PREFECT_API_URL: url}):
            yield url
        server.shutdown()
        thread.join()


def test_deploying_with_a_wrong_password_names_it_in_one_sentence(url, tmp_path):
    with pytest.raises(Unusable) as refused:
        deploy_line(Home(tmp_path), "Europe/Berlin")
    assert str(refused.value) == f"Prefect's server {url} {REFUSED}; then repeat the command"


def test_an_order_that_waits_and_a_worker_say_that_the_password_is_wrong(url, tmp_path):
    notice = queue.submit([], Home(tmp_path))
    assert notice is not None
    assert REFUSED in notice
    assert "the order waits" in notice
    with pytest.raises(Unusable, match="then start the worker again"):
        queue.give_up_pending("station-A", Home(tmp_path))
