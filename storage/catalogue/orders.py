"""Production orders: kept under their number, begun once, and listed for each station."""

import json
import os
import socket
from collections.abc import Collection, Sequence
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sql

from schemas.base import NotThere, Unusable
from schemas.orders import OPEN, ProductionOrder, ProductionState
from schemas.text import Statement
from storage.catalogue import audit_trail, database, tables
from storage.home import Home

ORDER = tables.orders.c
MANY = 200  # of the last ones
JSON = ("units", "runs", "certificates")
WITH_CAUSE = '{"fault": '  # how a fault begins that has its cause beside it
WAITING: tuple[ProductionState, ...] = ("waiting",)
RUNNING: tuple[ProductionState, ...] = ("running",)
WAITING_AGAIN: dict[str, Any] = {
    "state": "waiting", "flow_run": None, "host": None, "process": None, "ended_at": None,
    "fault": None,
}  # fmt: skip


def add(new: Sequence[ProductionOrder], home: Home) -> list[tuple[ProductionOrder, bool]]:
    """Keep orders that wait, all or none; each as it is kept, and whether it is new.

    Raises Unusable where another order has the number of one.
    """
    with database.changing(home) as connection:
        return [_added(order, connection) for order in new]


def _added(order: ProductionOrder, connection: sql.Connection) -> tuple[ProductionOrder, bool]:
    if not database.add_new(connection, tables.orders, **_row_of(order)):
        kept = _kept(connection, order.number)
        check_same(order, kept)
        return kept, False
    audit_trail.add(
        connection, order.person, "order acquire", order.number, at=order.ordered_at,
        station=order.station, units=[unit.serial for unit in order.units],
        procedure=order.procedure,
    )  # fmt: skip
    return order, True


def check_number(order: ProductionOrder, home: Home) -> None:
    """Raises Unusable where another order has the number of this one."""
    for kept in numbered([order.number], home):
        check_same(order, kept)


def check_same(order: ProductionOrder, kept: ProductionOrder) -> None:
    """Raises Unusable where an order asks for something else than the one that has its number."""
    differing = order.differs_from(kept)
    if differing is not None:
        raise Unusable(
            f"order {order.number} is there already ({kept.serials} by {kept.procedure} on station "
            f"{kept.station}) and this one has another {differing}: give it another number"
        )


def find(number: str, home: Home) -> ProductionOrder:
    """The order with a number; raises Unusable where there is none."""
    for order in numbered([number], home):
        return order
    raise NotThere(f"there is no order {number!r}: `mimucal order list` names them")


def numbered(numbers: Collection[str], home: Home) -> list[ProductionOrder]:
    """The orders with some numbers, as far as there are any."""
    asked = sql.select(tables.orders).where(ORDER.number.in_(numbers))
    return [_order_of(row) for row in database.rows(home, asked)]


def listed(
    home: Home,
    station: str | None = None,
    states: Collection[ProductionState] = (),
    last: int | None = None,
) -> list[ProductionOrder]:
    """Orders, the oldest first: those of a station, in some states, the last so many; else all."""
    asked = sql.select(tables.orders).order_by(ORDER.ordered_at.desc(), ORDER.number.desc())
    if station is not None:
        asked = asked.where(ORDER.station == station)
    if states:
        asked = asked.where(ORDER.state.in_(states))
    return [_order_of(row) for row in reversed(database.rows(home, asked.limit(last)))]


def waiting(home: Home, station: str | None = None) -> list[ProductionOrder]:
    """The orders that wait, the one to be taken first at the beginning."""
    return listed(home, station, WAITING)


def claim(number: str, home: Home) -> ProductionOrder | None:
    """Take a waiting order for this process; None if it is no longer waiting.

    Of all who claim an order one gets it: the database changes its state once.
    """
    now = datetime.now(UTC)
    taken = (
        sql.update(tables.orders)
        .where(ORDER.number == number, ORDER.state == "waiting")
        .values(
            state="running", attempts=ORDER.attempts + 1, host=socket.gethostname(),
            process=os.getpid(), began_at=sql.func.coalesce(ORDER.began_at, now), fault=None,
        )
    )  # fmt: skip
    with database.changing(home) as connection:
        if connection.execute(taken).rowcount != 1:
            return None
        return _kept(connection, number)


def note(number: str, home: Home, cause: Statement | None = None, **what: Any) -> None:
    """Note what is known of an order meanwhile: runs, certificates, flow_run, fault and cause."""
    values = {k: json.dumps(value) if k in JSON else value for k, value in what.items()}
    if "fault" in what:
        values["fault"] = _fault(what["fault"], cause)
    with database.changing(home) as connection:
        connection.execute(sql.update(tables.orders).where(ORDER.number == number).values(**values))


def finish(
    number: str,
    state: ProductionState,
    home: Home,
    fault: str | None = None,
    cause: Statement | None = None,
    *,
    was: ProductionState = "running",
) -> bool:
    """End an order that runs: done, or failed with its fault; whether it still ran.

    was: waiting, of an order that is refused before it begins.
    """
    ended = {"state": state, "fault": _fault(fault, cause), "ended_at": datetime.now(UTC)}
    changed = sql.update(tables.orders).where(ORDER.number == number, ORDER.state == was)
    with database.changing(home) as connection:
        values = {"is_interrupted": (state, was) == ("failed", "running"), **ended}
        return bool(connection.execute(changed.values(**values)).rowcount)


def cancel(number: str, person: str, home: Home) -> ProductionOrder:
    """Cancel an order that waits; raises Unusable for one that has begun or ended."""
    changed = sql.update(tables.orders).where(ORDER.number == number, ORDER.state == "waiting")
    with database.changing(home) as connection:
        values = {"state": "cancelled", "ended_at": datetime.now(UTC)}
        if connection.execute(changed.values(**values)).rowcount:
            audit_trail.add(connection, person, "cancel order", number)
            return _kept(connection, number)
    order = find(number, home)
    way_out = "stop its run at the station" if order.state == "running" else "it has ended"
    raise Unusable(f"order {number} is {order.state} and waits no more: {way_out}")


def retry(number: str, person: str, home: Home, reason: str | None = None) -> ProductionOrder:
    """Put an order that failed or was cancelled back into the queue; Unusable for any other.

    One of which a run is invalid is measured again: the trail has its runs so far, and the reason,
    which is why it failed where the person gives none.
    """
    order = find(number, home)
    again: dict[str, Any] = {"again": True} | ({"reason": reason} if reason else {})
    values = WAITING_AGAIN
    if _is_invalid(order.runs, home):
        again |= {"reason": reason or order.fault, "runs": order.runs}
        fresh = {"is_interrupted": False, "began_at": None, "runs": "[]", "certificates": "[]"}
        values = WAITING_AGAIN | fresh
    changed = sql.update(tables.orders).where(
        ORDER.number == number, ORDER.state.in_(("failed", "cancelled"))
    )
    with database.changing(home) as connection:
        if connection.execute(changed.values(**values)).rowcount:
            audit_trail.add(connection, person, "order acquire", number, **again)
            return _kept(connection, number)
    raise Unusable(
        f"order {number} is {order.state}: only one that failed or was cancelled can be carried "
        "out again"
    )


def _is_invalid(runs: Sequence[str], home: Home) -> bool:
    """Whether the last result of one of some runs finds it invalid."""
    made = tables.outcomes.c
    asked = sql.select(made.run, made.verdict).where(made.run.in_(runs), made.terms == "")
    last = {row.run: row.verdict for row in database.rows(home, asked.order_by(made.made_at))}
    return "invalid" in last.values()


def measured_for(run: str, home: Home) -> tuple[str, int] | None:
    """The number of the order that a run was measured for, and which of its measurements it is: 1,
    or more where an invalid one was repeated; None where no order has the run.
    """
    entry, named = tables.trail.c, f'"{run}"'
    again = sql.select(entry.subject, entry.details).where(
        entry.action == "order acquire", entry.details.contains('"runs"')
    )
    before = [
        (row.subject, row.details) for row in database.rows(home, again.order_by(entry.number))
    ]
    has_run = ORDER.runs.contains(named, autoescape=True)
    last = database.rows(home, sql.select(ORDER.number).where(has_run))
    numbers = [number for number, runs in before if named in runs] + [row.number for row in last]
    if not numbers:
        return None
    repeated = [named in runs for number, runs in before if number == numbers[0]]
    return numbers[0], [*repeated, True].index(True) + 1


def put_back(station: str, home: Home) -> list[ProductionOrder]:
    """Put orders of a station whose process died back into the queue; returns them.

    For whoever holds the station's lock of orders: every order that runs is then one whose process
    is dead.
    """
    return [order for order in listed(home, station, RUNNING) if wait_again(order, home)]


def wait_again(order: ProductionOrder, home: Home) -> bool:
    """Put one order back whose process died; whether it was still as that process left it."""
    left = (ORDER.number == order.number, ORDER.state == "running")
    changed = sql.update(tables.orders).where(*left, ORDER.attempts == order.attempts)
    with database.changing(home) as connection:
        values = {"is_interrupted": True, **WAITING_AGAIN}
        return bool(connection.execute(changed.values(**values)).rowcount)


def running(home: Home) -> list[ProductionOrder]:
    """The orders that a process began and has not ended."""
    return listed(home, states=RUNNING)


def same_open(order: ProductionOrder, home: Home) -> ProductionOrder | None:
    """An open order for the same units by the same procedure on the same station, if any."""
    alike = ("units", "procedure", "client_order")
    for each in listed(home, order.station, OPEN):
        if all(getattr(each, name) == getattr(order, name) for name in alike):
            return each
    return None


def stored_since(order: ProductionOrder, home: Home) -> tuple[str, ...]:
    """The runs of an order that are in the store although the order does not name them.

    Its process died in between. Ids in the order of its units; none unless each has one.
    """
    run, unit = tables.runs.c, tables.units.c
    found: list[str] = []
    for each in order.units:
        named = (each.manufacturer, each.model, each.serial)
        asked = (
            sql.select(run.id)
            .join_from(tables.runs, tables.units)
            .where(run.station == order.station, run.imported_at >= order.began_at)
            .where(sql.tuple_(unit.manufacturer, unit.model, unit.serial) == sql.tuple_(*named))
            .order_by(run.imported_at.desc())
        )
        found += [row.id for row in database.rows(home, asked.limit(1))]
    return tuple(found) if len(found) == len(order.units) else ()


def _kept(connection: sql.Connection, number: str) -> ProductionOrder:
    asked = sql.select(tables.orders).where(ORDER.number == number)
    return _order_of(connection.execute(asked).one())


def _row_of(order: ProductionOrder) -> dict[str, Any]:
    plain = order.model_dump(mode="json")
    row: dict[str, Any] = order.model_dump(exclude={"units", "client_order", "cause"})
    row |= {name: json.dumps(plain[name], ensure_ascii=False) for name in JSON}
    client = order.client_order
    return row | {"client_order": client and client.model_dump_json()}


def _order_of(row: sql.Row[Any]) -> ProductionOrder:
    fields = dict(row._mapping)
    fields |= {name: json.loads(fields[name]) for name in JSON}
    if fields["client_order"] is not None:
        fields["client_order"] = json.loads(fields["client_order"])
    if (fields["fault"] or "").startswith(WITH_CAUSE):
        fields |= json.loads(fields["fault"])
    return ProductionOrder.model_validate(fields)


def _fault(fault: str | None, cause: Statement | None) -> str | None:
    """A fault as its column has it: mere text, or JSON with the cause beside it."""
    if fault is None or cause is None:
        return fault
    return json.dumps({"fault": fault, "cause": cause.model_dump(mode="json")}, ensure_ascii=False)
