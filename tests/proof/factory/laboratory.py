"""Those who check and issue certificates all day, in a thread of their own."""

import threading
from contextlib import suppress

import httpx

from tests.proof.factory.persons import Person, RefusedError
from tests.proof.factory.works import PASSWORD, PERSONS

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
