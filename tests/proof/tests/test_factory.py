"""The judge of the factory finds what is lost and what is done twice."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import psycopg
import pytest

from schemas.orders import ProductionOrder
from storage.catalogue import orders
from storage.home import Home
from tasks.stages.issue import check, issue
from tests import postgres
from tests.drafts import draft, recording_of
from tests.proof.factory.draw import REJECTED, OrderedUnit, ordered
from tests.proof.factory.judge import Facts, Order, Paper, Run, facts, judged

UNITS = ordered(1, 40, ("A", "B"))
REMINDED = "North Works"


def sound(units: tuple[OrderedUnit, ...] = UNITS) -> Facts:
    """All as it was promised."""
    good = [unit for unit in units if not unit.is_rejected]
    papers = [
        Paper(f"DEMO-2026-{n:04d}", f"draft-{u.serial}", f"r{u.serial}", "issued",
              u.verdict or "pass", ("Li", "Zhao", "Chen"), True)
        for n, u in enumerate(good, 1)
    ]  # fmt: skip
    sent = {
        paper.number: 1 for paper, unit in zip(papers, good, strict=True) if unit.client == REMINDED
    }
    return Facts(
        orders=tuple(
            Order(u.number, u.serial, "failed" if u.is_rejected else "done", (f"r{u.serial}",),
                  () if u.is_rejected else (f"draft-{u.serial}",), 1,
                  "invalid" if u.is_rejected else "")
            for u in units
        ),
        runs=tuple(Run(f"r{u.serial}", u.serial, is_kept=True) for u in units),
        papers=tuple(papers), mails=sent, reminders=dict(sent), interrupted=(),
    )  # fmt: skip


def broken(found: Facts) -> list[str]:
    return [row.promise for row in judged(UNITS, found) if not row.holds]


def test_what_is_as_promised_holds_throughout() -> None:
    assert any(unit.is_rejected for unit in UNITS)
    assert broken(sound()) == []


def _reminded(found: Facts) -> str:
    return next(iter(found.mails))


LOST: dict[str, Callable[[Facts], Facts]] = {
    "a run": lambda f: replace(f, runs=f.runs[1:]),
    "a recording": lambda f: replace(f, runs=(replace(f.runs[0], is_kept=False), *f.runs[1:])),
    "an order": lambda f: replace(f, orders=f.orders[1:]),
    "a certificate": lambda f: replace(f, papers=f.papers[1:]),
    "a number": lambda f: replace(f, papers=(replace(f.papers[0], number="DEMO-2026-9999"),
                                             *f.papers[1:])),
    "a mail": lambda f: replace(f, mails={n: k for n, k in f.mails.items() if n != _reminded(f)}),
    "the note of a mail": lambda f: replace(f, reminders={}),
    "what a station recorded": lambda f: replace(f, interrupted=("left.mcap",)),
    "a verdict": lambda f: replace(
        f, papers=(f.papers[0], replace(f.papers[1], verdict="inconclusive"), *f.papers[2:])
    ),
    "the issue": lambda f: replace(f, papers=(replace(f.papers[0], state="checked"),
                                              *f.papers[1:])),
    "the end of an order": lambda f: replace(f, orders=(replace(f.orders[0], state="running"),
                                                        *f.orders[1:])),
    "the end of a flow run": lambda f: replace(f, unfinished={"Running": 1}),
}  # fmt: skip
TWICE: dict[str, Callable[[Facts], Facts]] = {
    "a run": lambda f: replace(f, runs=(*f.runs, replace(f.runs[0], id="r2"))),
    "an order": lambda f: replace(f, orders=(*f.orders, replace(f.orders[0], number="F1-2"))),
    "a certificate": lambda f: replace(f, papers=(*f.papers, replace(f.papers[0], number="D-99"))),
    "a run in two orders": lambda f: replace(
        f, orders=(replace(f.orders[0], runs=f.orders[1].runs), *f.orders[1:])
    ),
    "a mail": lambda f: replace(f, mails={**f.mails, _reminded(f): 2}),
    "steps by one person": lambda f: replace(
        f, papers=(replace(f.papers[0], persons=("Li", "Zhao", "Zhao")), *f.papers[1:])
    ),
}


@pytest.mark.parametrize("what", LOST)
def test_what_is_lost_is_found(what: str) -> None:
    assert broken(LOST[what](sound()))


@pytest.mark.parametrize("what", TWICE)
def test_what_is_done_twice_is_found(what: str) -> None:
    assert broken(TWICE[what](sound()))


def test_a_certificate_of_a_rejected_unit_is_found() -> None:
    found = sound()
    rejected = next(unit for unit in UNITS if unit.fault in REJECTED)
    paper = replace(found.papers[0], number="DEMO-2026-0099", run=f"r{rejected.serial}")
    assert broken(replace(found, papers=(*found.papers, paper)))


@pytest.mark.rehearsal
def test_a_store_that_lost_a_run_or_has_one_twice_is_judged_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The facts are read from a real catalogue, which is then tampered with."""
    unit = OrderedUnit("F-1", "1", 1, "A", "jjf2003", "Harbour Instruments", None)
    with postgres.running() as server:
        monkeypatch.setenv("MIMUCAL_DATABASE", url := postgres.empty_database(server))
        home = Home(tmp_path)
        key = draft(home, "1").certificate.number
        check(key, home, "Li")
        issue(key, home, "Zhao")
        made = ProductionOrder(
            number="F-1", station="A", units=(recording_of("1").manifest.unit,),
            procedure="jjf2003", person="Wang", ordered_at=datetime.now(UTC),
        )  # fmt: skip
        orders.add([made], home)
        orders.claim("F-1", home)
        with psycopg.connect(url, autocommit=True) as catalogue:
            (run,) = catalogue.execute("SELECT id FROM runs").fetchone() or ("",)
            orders.note("F-1", home, runs=(run,), certificates=(key,))
            orders.finish("F-1", "done", home)

            def found() -> list[str]:
                read = facts(catalogue, tmp_path, tmp_path, tmp_path / "mails")
                return [row.promise for row in judged([unit], read) if not row.holds]

            assert found() == []
            catalogue.execute("UPDATE orders SET runs = '[]'")
            assert "Each run is that of one order" in found()
            catalogue.execute("CREATE TEMPORARY TABLE again AS SELECT * FROM orders")
            catalogue.execute("UPDATE again SET number = 'F-2'")
            catalogue.execute("INSERT INTO orders SELECT * FROM again")
            assert "Every order of the file is in the queue, and no other" in found()
