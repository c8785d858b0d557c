"""Questions to the Prefect server that PREFECT_API_URL names, without importing Prefect."""

from typing import Any

from schemas.base import Unusable
from storage.home import environment

CLIENT_AUTH = "PREFECT_API_AUTH_STRING"  # `user:password` of the client
SERVER_AUTH = "PREFECT_SERVER_API_AUTH_STRING"  # the same on the server

TIMEOUT_S = 3.0
REFUSED = 401


class NotAnswered(Unusable):
    """The server is away, or refuses."""


def get(path: str) -> Any:
    """The answer to a path of the API, such as `/health`; raises NotAnswered."""
    return _ask("GET", path, None)


def post(path: str, asked: dict[str, Any]) -> Any:
    """The answer to a filter, such as that of `/flow_runs/filter`; raises NotAnswered."""
    return _ask("POST", path, asked)


def is_open() -> bool:
    """Whether the server answers without a password."""
    try:
        _ask("GET", "/admin/version", None, with_password=False)
    except NotAnswered:
        return False
    return True


def is_refusal(error: Exception) -> bool:
    """Whether it is the server's answer to a wrong password, or to none."""
    import httpx

    return isinstance(error, httpx.HTTPStatusError) and error.response.status_code == REFUSED


def credentials() -> tuple[str, str] | None:
    """User and password of CLIENT_AUTH, where the server asks for them."""
    user, _, password = (environment().prefect_login or "").partition(":")
    return (user, password) if user else None


def _ask(method: str, path: str, asked: dict[str, Any] | None, with_password: bool = True) -> Any:
    import httpx

    url = (environment().prefect_server or "").rstrip("/")
    try:
        auth = credentials() if with_password else None
        answer = httpx.request(method, f"{url}{path}", json=asked, auth=auth, timeout=TIMEOUT_S)
        answer.raise_for_status()
        return answer.json()
    except (httpx.HTTPError, httpx.InvalidURL, ValueError) as error:
        if is_refusal(error):
            raise NotAnswered(f"{url} refused {CLIENT_AUTH}") from error
        raise NotAnswered(f"{url} does not answer ({type(error).__name__}: {error})") from error
