"""Persons who check and issue certificates on the pages all day, as a browser does."""

import json
import threading
from contextlib import suppress
from typing import Any

import httpx

from tests.proof.factory.works import PASSWORD, PERSONS

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


# Those who check and issue, each in a thread.

LOOK_S = 1.0
STEP_OF = {"verifier": ("draft", "check"), "issuer": ("checked", "issue")}


class Laboratory:
    """Checks each draft and issues each checked certificate, on the pages."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._end = threading.Event()
        self._threads = [
            threading.Thread(target=self._work, args=(name, *STEP_OF[role]), daemon=True)
            for name, role in PERSONS.items()
            if role in STEP_OF
        ]
        self.refusals: list[str] = []

    def begin(self) -> None:
        for thread in self._threads:
            thread.start()

    def end(self) -> None:
        self._end.set()
        for thread in self._threads:
            thread.join()

    def _work(self, name: str, state: str, step: str) -> None:
        person: Person | None = None
        while not self._end.wait(LOOK_S):
            try:
                if person is None:
                    person = Person(name, PASSWORD, self._url)
                    person.log_in()
                for each in person.shown("do")["certificates"]:
                    if each["state"] == state:
                        person.give(step, certificate=each["number"])
            except (
                RefusedError
            ) as refused:  # by a page that came back, or for good: the judge sees it
                self.refusals.append(str(refused)[:300])
                _close(person)
                person = None
            except (httpx.HTTPError, KeyError, ValueError):  # the pages are away
                _close(person)
                person = None
        _close(person)


def _close(person: Person | None) -> None:
    if person is not None:
        with suppress(httpx.HTTPError):
            person.close()
