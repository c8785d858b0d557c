"""A browser without manners: sends whatever it is given, byte for byte, and follows nothing."""

import json
from dataclasses import dataclass, field
from http.client import HTTPConnection
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import urlencode, urlsplit

from tests.proof.hostile.attacked import PASSWORD

TIMEOUT_S = 60.0
FORM, JSON = "application/x-www-form-urlencoded", "application/json"


@dataclass(frozen=True)
class Answer:
    """What came back."""

    status: int
    location: str
    text: str


@dataclass
class Browser:
    """One visitor, with the cookies it was given."""

    address: str
    cookies: dict[str, str] = field(default_factory=dict)

    def send(
        self, method: str, path: str, body: str = "", kind: str = "", **headers: str
    ) -> Answer:
        """One request. headers: with `_` for `-`."""
        host = urlsplit(self.address)
        connection = HTTPConnection(host.hostname or "", host.port, timeout=TIMEOUT_S)
        connection.putrequest(method, path, skip_host="Host" in headers)
        sent = {name.replace("_", "-"): value for name, value in headers.items()}
        if self.cookies:
            sent["Cookie"] = "; ".join(f"{name}={value}" for name, value in self.cookies.items())
        if body:
            sent |= {"Content-Type": kind, "Content-Length": str(len(body.encode()))}
        for name, value in sent.items():
            connection.putheader(name, value)
        connection.endheaders(body.encode() or None)
        try:
            given = connection.getresponse()
            text = given.read().decode("utf-8", "replace")
            for header in given.headers.get_all("Set-Cookie") or []:
                self.cookies |= {name: m.value for name, m in SimpleCookie(header).items()}
            return Answer(given.status, given.headers.get("Location", ""), text)
        finally:
            connection.close()

    def token(self) -> str:
        """The token against forged requests that a form of this visitor has."""
        page = self.send("GET", "/login", Accept="text/html").text
        return page.partition('name="csrf_token" value="')[2].partition('"')[0]

    def log_in(self, name: str, password: str = PASSWORD, wanted: str = "/runs") -> Answer:
        """By the form."""
        fields = {"name": name, "password": password, "next": wanted, "csrf_token": self.token()}
        return self.send("POST", "/login", urlencode(fields), FORM)

    def log_out(self) -> Answer:
        """By the button."""
        return self.send("POST", "/logout", urlencode({"csrf_token": self.token()}), FORM)

    def update(self, content: Any, token: str | None = None) -> Answer:
        """Calls a callback of the pages."""
        headers = {} if token is None else {"X_CSRFToken": token}
        return self.send("POST", "/_dash-update-component", json.dumps(content), JSON, **headers)

    def order(self, action: str, fields: dict[str, Any], token: str | None = None) -> Answer:
        """Gives an order as the button of the Do page does."""
        return self.update(pressed(action, fields), token)


def pressed(action: str, fields: dict[str, Any]) -> dict[str, Any]:
    """What a browser sends when the button of an order is pressed."""
    ids = [{"of": action, "field": name} for name in fields]
    values = [
        {"id": i, "property": "value", "value": v}
        for i, v in zip(ids, fields.values(), strict=True)
    ]
    same = [{"id": i, "property": "id", "value": i} for i in ids]
    button = {"do": action}
    return {
        "output": "do-answer.children",
        "outputs": {"id": "do-answer", "property": "children"},
        "inputs": [[{"id": button, "property": "n_clicks", "value": 1}]],
        "changedPropIds": [json.dumps(button, separators=(",", ":")) + ".n_clicks"],
        "state": [values, same],
    }
