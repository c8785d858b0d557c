"""Persons who log in to the pages and take the steps of certificates there, as a browser does."""

import json
from typing import Any

import httpx

TIMEOUT_S = 60.0


class RefusedError(RuntimeError):
    """The pages did not do what was asked of them."""


class Person:
    """Somebody with a session on the pages."""

    def __init__(self, name: str, password: str, url: str) -> None:
        self.name, self._password = name, password
        self._client = httpx.Client(base_url=url, trust_env=False, timeout=TIMEOUT_S)

    def log_in(self) -> None:
        """Raises RefusedError where the pages do not know the name or the password."""
        page = self._client.get("/login").text
        token = page.partition('name="csrf_token" value="')[2].partition('"')[0]
        form = {"name": self.name, "password": self._password, "next": "/do", "csrf_token": token}
        answer = self._client.post("/login", data=form)
        if answer.status_code != 302:
            raise RefusedError(f"{self.name} cannot log in ({answer.status_code})")
        self._client.get("/do")  # sets the token that the page's script sends back

    def shown(self, page: str, **asked: str) -> Any:
        """The JSON of a page; raises RefusedError where it is refused."""
        answer = self._client.get(f"/api/v1/{page}", params=asked)
        if answer.status_code != 200:
            raise RefusedError(f"{page}: {answer.status_code} {answer.text[:500]}")
        return answer.json()

    def give(self, action: str, **fields: str) -> str:
        """Press a button of Do; what the page answers. Raises RefusedError."""
        ids = [{"field": name, "of": action} for name in fields]
        button = json.dumps({"do": action}, separators=(",", ":"))
        body = {
            "output": "do-answer.children",
            "outputs": {"id": "do-answer", "property": "children"},
            "changedPropIds": [f"{button}.n_clicks"],
            "inputs": [[{"id": {"do": action}, "property": "n_clicks", "value": 1}]],
            "state": [
                [_state(i, "value", text) for i, text in zip(ids, fields.values(), strict=True)],
                [_state(id_, "id", id_) for id_ in ids],
            ],
        }  # fmt: skip
        token = self._client.cookies.get("_csrf_token") or ""
        answer = self._client.post(
            "/_dash-update-component", json=body, headers={"X-CSRFToken": token}
        )
        if answer.status_code != 200:
            raise RefusedError(f"{action}: {answer.status_code} {answer.text[:500]}")
        alert = answer.json()["response"]["do-answer"]["children"]["props"]
        sentence = f"{alert.get('title', '')} {alert['children']}".strip()
        if alert["color"] != "green":
            raise RefusedError(f"{action} {fields}: {sentence}")
        return sentence

    def close(self) -> None:
        self._client.close()


def _state(id_: dict[str, str], name: str, value: object) -> dict[str, object]:
    return {"id": id_, "property": name, "value": value}
