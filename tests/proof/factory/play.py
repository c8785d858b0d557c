"""Two days of production: orders, operators, the laboratory, and what is killed meanwhile."""

import csv
import os
import random
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil
import psycopg

from tests.proof.factory.draw import OrderedUnit
from tests.proof.factory.judge import Order, Paper, orders_of, papers_of
from tests.proof.factory.laboratory import Laboratory
from tests.proof.factory.operators import Operator, Stop
from tests.proof.factory.works import STATIONS, Works

# Each part is killed once at a random moment of the play, and started again some seconds later.

DELAY_S, AWAY_S = (0.0, 6.0), (1.0, 4.0)  # from when it is due to the kill; without it


@dataclass(frozen=True)
class Happened:
    """What was killed, after how many orders, and how long (s) until it answered again."""

    part: str
    after: int
    away_s: float


@dataclass
class _Next:
    part: str
    due: int  # orders that are done
    delay_s: float
    away_s: float
    due_s: float | None = None
    killed_s: float | None = None
    begun: bool = False


class Disturbances:
    """Kills, one at a time; `tick` is called some times a second."""

    def __init__(
        self, works: Works, parts: Sequence[str], total: int, rng: random.Random,
        came_back: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._works, self._came_back, self._total = works, came_back, total
        shuffled = rng.sample(list(parts), len(parts))
        dues = [total * number // (len(parts) + 1) for number in range(len(parts))]
        self._left = [
            _Next(part, due, rng.uniform(*DELAY_S), rng.uniform(*AWAY_S))
            for part, due in zip(shuffled, dues, strict=True)
        ]  # fmt: skip
        self.happened: list[Happened] = []
        self._killed = ("", 0)

    @property
    def is_over(self) -> bool:
        return not self._left

    @property
    def away(self) -> str | None:
        """The part that is away just now."""
        is_away = bool(self._left) and self._left[0].killed_s is not None
        return self._left[0].part if is_away else None

    def tick(self, done: int) -> None:
        """done: orders."""
        if not self._left:
            return
        now_s, turn = time.monotonic(), self._left[0]
        if turn.killed_s is None:
            if turn.due_s is None and done >= turn.due:
                turn.due_s = now_s + turn.delay_s
            if turn.due_s is not None and now_s >= turn.due_s and self._kill(turn.part):
                turn.killed_s = now_s
            elif turn.part == OF_A_RUN and done >= self._total:  # there is no run any more
                del self._left[0]
        elif not turn.begun and now_s >= turn.killed_s + turn.away_s:
            self._begin(turn.part)
            turn.begun = True
        elif turn.begun and self._is_up(turn.part):
            self.happened.append(Happened(turn.part, done, now_s - turn.killed_s))
            self._came_back(turn.part)
            del self._left[0]

    def _kill(self, part: str) -> bool:
        """Whether it was there to be killed."""
        if part == OF_A_RUN:
            running = self._running()
            if not running:
                return False
            self._killed = next(iter(running.items()))
            os.kill(self._killed[1], signal.SIGKILL)
        elif part == "PostgreSQL":
            self._works.database.kill()
        else:
            self._works.parts[part].kill()
        return True

    def _running(self) -> dict[str, int]:
        """The processes of the orders that measure, by the number of the order."""
        asked = "SELECT number, process FROM orders WHERE state = 'running' AND runs = '[]'"
        with self._works.database.connected("mimucal") as connection:
            return dict(connection.execute(asked).fetchall())

    def _begin(self, part: str) -> None:
        if part == OF_A_RUN:
            return
        if part == "PostgreSQL":
            self._works.database.start()
        else:
            self._works.parts[part].begin()

    def _is_up(self, part: str) -> bool:
        if part == OF_A_RUN:  # the order is no longer held by the dead process
            number, process = self._killed
            return self._running().get(number) != process
        return part == "PostgreSQL" or self._works.parts[part].answers()


OF_A_RUN = "a run's own process"
PARTS = (
    OF_A_RUN,
    "PostgreSQL", "Prefect server", "S3", "pages", "mail sink", "dask scheduler", "worker line",
    *(f"worker station-{id_}" for id_ in STATIONS), *STATIONS,
)  # fmt: skip


# The play itself.

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

    def look(self, orders: Sequence[Order]) -> None:
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


def state(works: Works) -> tuple[list[Order], list[Paper]] | None:
    """Orders and certificates; None while the database is away."""
    try:
        with works.database.connected("mimucal") as connection:
            return list(orders_of(connection)), list(papers_of(connection))
    except psycopg.Error:
        return None


def _is_over(
    orders: Sequence[Order], papers: Sequence[Paper], known: dict[str, OrderedUnit]
) -> bool:
    done = [order for order in orders if order.state == "done"]
    rejected = {number for number, unit in known.items() if unit.is_rejected}
    failed = [o for o in orders if o.state == "failed" and o.number in rejected and o.runs]
    issued = {paper.run for paper in papers if paper.state == "issued"}
    return len(done) + len(failed) == len(known) and all(set(o.runs) <= issued for o in done)
