"""Two days of production: orders, the operators, the laboratory, and what goes wrong meanwhile."""

import csv
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil
import psycopg

from tests.proof.factory import facts
from tests.proof.factory.disturbances import PARTS, Disturbances, Happened
from tests.proof.factory.draw import OrderedUnit
from tests.proof.factory.laboratory import Laboratory
from tests.proof.factory.operators import Operator
from tests.proof.factory.stop import Stop
from tests.proof.factory.works import STATIONS, Works

TICK_S = 0.25
STOP_AFTER = 3  # a third of the orders, the stop is pressed
COLUMNS = ("number", "station", "serial", "procedure", "client_order")


@dataclass(frozen=True)
class Played:
    """What happened. units: the orders, with those of units that were measured anew. stop: of which
    order, after how long (s) its table was at rest, whether the unit says so, too. wrong: the order
    for which the wrong unit was mounted. seconds: wall time of production, to the last certificate.
    held_s: for how long (s) an order was held by a dead process while every part was up.
    """

    units: tuple[OrderedUnit, ...]
    stop: Stop
    happened: tuple[Happened, ...]
    events: tuple[str, ...]
    refusals: tuple[str, ...]
    wrong: str
    seconds: float
    is_over: bool
    held_s: float


def write_orders(units: Sequence[OrderedUnit], works: Works) -> Path:
    """The orders as the CSV that a manufacturing system would write."""
    with works.orders.open("w", encoding="utf-8", newline="") as opened:
        rows = csv.writer(opened)
        rows.writerow(COLUMNS)
        for unit in units:
            procedure = works.procedure_of(unit.procedure)
            client = works.client_order(unit.client)
            rows.writerow((unit.number, unit.station, unit.serial, procedure, client))
    return works.orders


def play(
    works: Works, units: Sequence[OrderedUnit], seed: int, longest_s: float,
    report: Callable[[int, int], None], parts: Sequence[str] = PARTS,
) -> Played:  # fmt: skip
    """Produce until every order has ended and its certificate is issued, or time is over.

    parts: what is killed, one after another.
    """
    rng, known = random.Random(seed), {unit.number: unit for unit in units}
    wrong = rng.choice([unit.number for unit in units if unit.fault is None])
    late = rng.choice([unit.number for unit in units if unit.number != wrong])
    operators = {
        id_: Operator(works, id_, known, random.Random(rng.random()), wrong, late)
        for id_ in STATIONS
    }

    def came_back(part: str) -> None:
        if part in operators:
            operators[part].came_back()

    disturbances, held = Disturbances(works, parts, len(units), rng, came_back), Held()
    stop = Stop(works)
    laboratory = Laboratory(works.pages_url)
    began_s = time.monotonic()
    works.command("order", "import", write_orders(units, works), "--by", "Li Na")
    works.order_by_schedule(STATIONS[0])
    laboratory.begin()
    is_over = False
    while not is_over and time.monotonic() < began_s + longest_s:
        time.sleep(TICK_S)
        found = state(works)
        done = 0
        if found is not None:
            orders, papers = found
            done = sum(order.state in ("done", "failed") for order in orders)
            for id_, operator in operators.items():
                if id_ != disturbances.away:
                    operator.tick(orders)
            held.look(orders if disturbances.away is None else ())
            if disturbances.away is None:
                stop.tick(orders, len(units) // STOP_AFTER)
            report(done, len(known))
            is_over = disturbances.is_over and _is_over(orders, papers, known)
        disturbances.tick(done)
        works.keep_up(disturbances.away)
    seconds = time.monotonic() - began_s
    laboratory.end()
    events = tuple(event for each in operators.values() for event in each.events)
    return Played(
        tuple(known.values()),
        stop,
        tuple(disturbances.happened),
        events,
        tuple(laboratory.refusals),
        wrong,
        seconds,
        is_over,
        held.longest_s,
    )


class Held:
    """For how long orders are held by processes that are dead."""

    def __init__(self) -> None:
        self.longest_s = 0.0
        self._since_s: dict[tuple[str, int], float] = {}

    def look(self, orders: Sequence[facts.Order]) -> None:
        """At orders as they stand; none while a part is away, which begins the time anew."""
        now_s = time.monotonic()
        dead = {
            (each.number, each.process)
            for each in orders
            if each.state == "running" and each.process and not psutil.pid_exists(each.process)
        }
        self._since_s = {each: self._since_s.get(each, now_s) for each in dead}
        for since_s in self._since_s.values():
            self.longest_s = max(self.longest_s, now_s - since_s)


def state(works: Works) -> tuple[list[facts.Order], list[facts.Paper]] | None:
    """Orders and certificates; None while the database is away."""
    try:
        with works.database.connected("mimucal") as connection:
            return list(facts.orders_of(connection)), list(facts.papers_of(connection))
    except psycopg.Error:
        return None


def _is_over(
    orders: Sequence[facts.Order], papers: Sequence[facts.Paper], known: dict[str, OrderedUnit]
) -> bool:
    done = [order for order in orders if order.state == "done"]
    rejected = {number for number, unit in known.items() if unit.is_rejected}
    failed = [o for o in orders if o.state == "failed" and o.number in rejected and o.runs]
    issued = {paper.run for paper in papers if paper.state == "issued"}
    return len(done) + len(failed) == len(known) and all(set(o.runs) <= issued for o in done)
