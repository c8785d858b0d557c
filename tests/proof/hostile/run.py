"""Hostile calls of a line's Prefect server and pages, and what became of each."""

import base64
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import httpx

from flows.orders.signed_orders import sign
from flows.progress import counting
from storage.catalogue import trail
from storage.home import Home
from tests.pages_server import served
from tests.proof.hostile.attacked import Attacked, attacked, log_lines
from tests.proof.hostile.forged_orders import RIGHTLY, Forged, forged, orders_of, replay
from tests.proof.hostile.line import FLOWS, Line, line_at
from tests.proof.hostile.page_calls import all_calls, is_refused, logins
from tests.proof.report import line, publish

MOST = 12  # forged orders that become flow runs, one of each kind; each takes several seconds
TEXT = """# Hostile calls

`make prove ARGS="--hostile {count}"`: a Prefect server with authentication and a process that
carries out its flows, the operations pages with a user of each role, and a home with a draft, a
checked and an issued certificate. Orders to check, issue and withdraw name a certificate in the
state that would let them act; those of runs and stations name some that are not there. Forged
orders are given by somebody who has the server's password.

| what was tried | calls | refused | logged |
|---|---:|---:|---:|
{rows}
| together | {calls} | {refused} | {logged} |

Refused: answered by an error, the login or a sentence, a login that leads to no other host, or a
flow run that failed. Logged: a line of `mimucal.access`, an entry of the trail, or a line of the
server's log. Afterwards certificates, their files, results, runs, orders and users were
{unchanged}, and the trail had {entries} new entries, all of logins and refusals.

The same withdrawal with the signature of the issuer, given to the same server: {control}.
{seconds:.0f} s.
"""


@dataclass(frozen=True)
class Tried:
    """One call, and what became of it."""

    kind: str
    what: str
    refused: bool
    logged: bool


@dataclass(frozen=True)
class Attack:
    """All calls, what they changed, how many entries of the trail they left, and how the order
    ended that was meant.
    """

    tried: tuple[Tried, ...]
    acted: tuple[str, ...]
    entries: int
    control: str
    seconds: float

    @property
    def calls(self) -> int:
        return len(self.tried)

    @property
    def faults(self) -> tuple[str, ...]:
        """What should not have been."""
        wrong = [f"{t.kind}: {t.what}" for t in self.tried if not (t.refused and t.logged)]
        control = () if self.control == "COMPLETED" else (f"what was meant: {self.control}",)
        return (*wrong, *self.acted, *control)


def run_on_line(folder: Path, most: int) -> Attack:
    """Attacks a line in a folder. most: of the forged orders that become flow runs."""
    began = time.monotonic()
    home = Home(folder / "home")
    os.environ["MIMUCAL_HOME"] = str(home.path)
    for name in ("bare", "prefect"):
        (folder / name).mkdir()
    there = attacked(home)
    again, use = replay(there)
    use()
    there.look()
    tried = [*_pages(there, folder)]
    with line_at(home, folder / "prefect") as made:
        tried += _without_password(made)
        tried += _flow_runs(made, there, [*_spread(list(forged(there)), most - 1), again])
        acted, entries = there.acted(), len(trail.entries(home)) - there.entries
        meant = sign("withdraw", orders_of(there, RIGHTLY)["withdraw"])
        run = made.order("withdraw", meant.model_dump(mode="json"))
        control = made.ended([run])[run][0]
    return Attack(tuple(tried), tuple(acted), entries, control, time.monotonic() - began)


def _spread(calls: list[Forged], most: int) -> list[Forged]:
    """So many calls, of every kind in turn."""
    by_kind: dict[str, list[Forged]] = {}
    for call in calls:
        by_kind.setdefault(call.kind, []).append(call)
    longest = max(map(len, by_kind.values()))
    kinds = list(by_kind.values())[::-1]
    in_turn = [calls[n] for n in range(longest) for calls in kinds if n < len(calls)]
    return in_turn[:most]


def _pages(there: Attacked, folder: Path) -> Iterator[Tried]:
    with log_lines() as lines, served(there.home) as a, served(Home(folder / "bare")) as bare:
        for call in all_calls(there, a, bare):
            logged = len(lines)
            answer = call.send()
            yield Tried(call.kind, call.what, is_refused(answer), len(lines) > logged)
        for call in logins(a):
            logged = len(lines)
            yield Tried(call.kind, call.what, call.send().location == "/", len(lines) > logged)


def _without_password(made: Line) -> Iterator[Tried]:
    """Prefect's server, asked by somebody without its password, and with wrong ones."""
    wrong = base64.b64encode(b"line:wrong").decode()
    for given in ("", f"Basic {wrong}", "Basic", "Basic !!!", f"Bearer {made.auth[1]}"):
        for method, path in (
            ("POST", "/deployments/filter"), ("POST", "/flow_runs/filter"), ("POST", "/flow_runs/"),
            *(("GET", f"/deployments/name/{flow}/{flow}") for flow in FLOWS[:3]),
            ("GET", "/admin/settings"), ("DELETE", "/work_pools/line"),
        ):  # fmt: skip
            before = _refusals(made)
            headers = {"Authorization": given} if given else {}
            answer = httpx.request(method, f"{made.api}{path}", headers=headers, timeout=60.0)
            logged = _later(partial(_has_more_refusals, made, before))
            what = f"{method} {path}, {given.split()[0] if given else 'nothing'}"
            refused = answer.status_code == httpx.codes.UNAUTHORIZED
            yield Tried("Prefect without its password", what, refused, logged)


def _later(holds: Callable[[], bool]) -> bool:
    end_s = time.monotonic() + 5.0
    while not holds():
        if time.monotonic() > end_s:
            return False
        time.sleep(0.05)
    return True


def _has_more_refusals(made: Line, before: int) -> bool:
    return _refusals(made) > before


def _refusals(made: Line) -> int:
    return made.log.read_text(encoding="utf-8", errors="replace").count(" 401")


def _flow_runs(made: Line, there: Attacked, calls: list[Forged]) -> Iterator[Tried]:
    """Forged orders, given to the server by somebody who has its password."""
    runs = {made.order(call.flow, call.parameters): call for call in calls}
    with counting("forged orders") as report:
        report(0, len(runs))
        ended = made.ended(list(runs))
        report(len(runs), len(runs))
    entries = "\n".join(entry.details for entry in trail.entries(there.home)[there.entries :])
    for run, call in runs.items():
        state, message = ended.get(run, ("", ""))
        what = f"{call.flow}: {message[:60]}"
        yield Tried(f"order: {call.kind}", what, state == "FAILED", run in entries)


def run_hostile(count: int, seed: int, write: bool) -> None:
    """Hold it and print the page; exit 1 where something is wrong. write: into the evidence.

    seed: nothing here is drawn.
    """
    with tempfile.TemporaryDirectory(prefix="mimucal-hostile-") as name:
        done = run_on_line(Path(name), count)
    kinds: dict[str, list[Tried]] = {}
    for each in done.tried:
        kinds.setdefault(each.kind, []).append(each)
    rows = [
        line((kind, len(t), sum(x.refused for x in t), sum(x.logged for x in t)))
        for kind, t in kinds.items()
    ]
    page = TEXT.format(
        count=count, rows="\n".join(rows), calls=done.calls, control=done.control,
        refused=sum(t.refused for t in done.tried), logged=sum(t.logged for t in done.tried),
        unchanged="as before" if not done.acted else f"changed ({', '.join(done.acted)})",
        entries=done.entries, seconds=done.seconds,
    )  # fmt: skip
    for fault in done.faults:
        print(fault)
    publish("hostile.md", page, write, bool(done.faults))
