"""What was promised, and what came of it."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tests.proof.factory.draw import EVERY_MONTH, OrderedUnit
from tests.proof.factory.facts import Facts, Order

LIVE = ("draft", "checked", "issued")
SHOWN = 4  # of what is wrong


@dataclass(frozen=True)
class Row:
    """A promise, what was to come, what came, and whether that is the same."""

    promise: str
    expected: str
    got: str
    holds: bool


def row(promise: str, expected: object, got: object) -> Row:
    """The row of what is to be equal."""
    return Row(promise, str(expected), str(got), expected == got)


def none_of(promise: str, wrong: Iterable[str]) -> Row:
    """The row of what is to be none."""
    found = sorted(wrong)
    shown = "; ".join(found[:SHOWN]) + (f"; … ({len(found)})" if len(found) > SHOWN else "")
    return Row(promise, "none", shown or "none", not found)


def judged(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    """Orders, runs, certificates and reminders against each other."""
    return [
        *_orders(ordered, facts),
        *_runs(ordered, facts),
        *_certificates(ordered, facts),
        *_reminders(ordered, facts),
    ]


def _orders(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    states = Counter(order.state for order in facts.orders)
    rejected = sum(unit.is_rejected for unit in ordered)
    asked = {unit.number: unit.serial for unit in ordered}
    there = {order.number: order.serial for order in facts.orders}
    differing = {n for n in asked.keys() | there.keys() if asked.get(n) != there.get(n)}
    return [
        none_of("Every order of the file is in the queue, and no other", differing),
        row("Orders of sound units are done", len(ordered) - rejected, states["done"]),
        row("Orders of faulty units have failed, with a reason", rejected, sum(
            order.state == "failed" and bool(order.fault) for order in facts.orders
        )),
        none_of("No order waits or runs", (
            f"{order.number} {order.state}"
            for order in facts.orders
            if order.state in ("waiting", "running")
        )),
        none_of("No flow run of Prefect's is late, pending or running", (
            f"{count} {state}" for state, count in facts.unfinished.items()
        )),
    ]  # fmt: skip


def _runs(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    asked = Counter(unit.serial for unit in ordered)
    of_serial = Counter(run.serial for run in facts.runs)
    used = Counter(run for order in facts.orders for run in order.runs)
    return [
        none_of("Each order measured its unit, and once", (
            f"{serial}: {of_serial[serial]} runs"
            for serial, orders in asked.items()
            if of_serial[serial] != orders
        )),
        none_of("No run is of a unit that was not ordered",
                of_serial.keys() - asked.keys()),
        none_of("Each run is that of one order", (
            f"{run.id} ({run.serial}): {used[run.id]} orders"
            for run in facts.runs
            if used[run.id] != 1
        )),
        none_of("No order names a run that is not there", used.keys() - {r.id for r in facts.runs}),
        none_of("Every raw recording is in the bucket",
                (run.id for run in facts.runs if not run.is_kept)),
        none_of("No recording is left at a station", facts.interrupted),
    ]  # fmt: skip


def _certificates(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    rejected = {unit.number for unit in ordered if unit.is_rejected}
    live = [paper for paper in facts.papers if paper.state in LIVE]
    of_run = Counter(paper.run for paper in live)
    issued = [paper for paper in facts.papers if paper.state == "issued"]
    wrong = [
        f"{order.number}: {count} certificates"
        for order in facts.orders
        if (count := _count(order, of_run)) != (order.number not in rejected)
    ]
    serials = Counter(int(paper.number.rpartition("-")[2]) for paper in issued)
    due = Counter(range(1, len(issued) + 1))
    serial_of = {run.id: run.serial for run in facts.runs}
    verdicts = {serial_of.get(paper.run): paper.verdict for paper in live}
    unlike = [
        f"{unit.serial}: {verdicts.get(unit.serial)}, planted {unit.verdict}"
        for unit in ordered
        if unit.verdict is not None and verdicts.get(unit.serial) != unit.verdict
    ]
    return [
        none_of("Units pass, fail and stay inconclusive as they were planted", unlike),
        none_of("Each order that is done has one certificate, and no other order has one", wrong),
        none_of("Each certificate is issued",
                (f"{paper.number} {paper.state}" for paper in live if paper.state != "issued")),
        none_of("The serial numbers of certificates are 1, 2, 3 …, none twice",
                map(str, ((serials - due) + (due - serials)).keys())),
        none_of("Drafted, checked and issued by three persons", (
            f"{paper.number}: {', '.join(paper.persons)}"
            for paper in issued
            if len(set(paper.persons)) != 3
        )),
    ]  # fmt: skip


def _count(order: Order, of_run: "Counter[str]") -> int:
    return sum(of_run[run] for run in order.runs)


def _reminders(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    """Of units that come back in a month; the others are due long after."""
    reminded = {u.serial for u in ordered if u.client == EVERY_MONTH and not u.is_rejected}
    serial = {run.id: run.serial for run in facts.runs}
    wrong = []
    for paper in facts.papers:
        if paper.state == "issued":
            due = int(serial.get(paper.run) in reminded)
            mails, noted = facts.mails.get(paper.number, 0), facts.reminders.get(paper.number, 0)
            if (mails, noted) != (due, due):
                wrong.append(f"{paper.number}: {mails} mails, {noted} noted, {due} due")
    return [
        row("Reminders that are due came to their clients", len(reminded), facts.mails_total),
        none_of("Each reminder came once, and is noted once", wrong),
    ]
