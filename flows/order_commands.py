"""The queue of each station: `mimucal order add|import|scan|list|cancel|retry`."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flows import options
from schemas.base import Unusable
from storage.home import home

if TYPE_CHECKING:
    from flows.orders.production import QueuedOrder


app = typer.Typer(
    help="Production orders: which unit is measured on which station, for whom.",
    rich_markup_mode=None,
)
SHOWN = 200  # orders of a list in a terminal, the last ones


@app.command(epilog="Example: mimucal order add LINE-1 --serial V00012 --client-order order.toml")
def add(
    station: options.OrderedStation,
    serial: options.Serials,
    model: options.OrderedModel = None,
    manufacturer: options.OrderedManufacturer = None,
    procedure: options.Procedure = "jjf2003",
    client_order: options.ClientOrder = None,
    number: options.OrderNumber = None,
    by: options.By = None,
    as_json: options.Json = False,
) -> None:
    """Order the calibration of a unit; it is measured when the station is free.

    The same order under the same number is one order.
    """
    from flows.orders.order_files import client_order_named, request_of
    from flows.orders.production import give

    units = [{"serial": each, "model": model, "manufacturer": manufacturer} for each in serial]
    request = request_of(
        number=number,
        station=station,
        units=units,
        procedure=procedure,
        client_order=client_order_named(client_order or "", Path()),
    )
    _print_given([give(request, options.person(by), home())], as_json)


@app.command(name="import", epilog="Example: mimucal order import orders.csv")
def import_(file: options.OrdersFile, by: options.By = None, as_json: options.Json = False) -> None:
    """Take in the orders of a CSV file, all of them or none.

    Columns: number, station, serial, and if wanted manufacturer, model, procedure, client_order (a
    file, as seen from the folder of this one). Every fault of the file is reported at once.
    """
    from flows.orders.order_files import read_orders
    from flows.orders.production import give_all

    person = options.person(by)
    requests, faults = read_orders(file, person, home())
    if faults:
        for fault in faults[:-1]:
            print(fault, file=sys.stderr)
        raise Unusable(f"{faults[-1]}; faults in {file}: {len(faults)}, orders placed: 0")
    _print_given(give_all(requests, person, home()), as_json)


@app.command(epilog="Example: mimucal order scan LINE-1")
def scan(
    station: options.OrderedStation, by: options.By = None, as_json: options.Json = False
) -> None:
    """Order a unit for each line of a scanner on standard input, until it ends.

    A line is SERIAL, or MANUFACTURER,MODEL,SERIAL[,PROCEDURE[,CLIENT_ORDER]]; the client's order is
    a file in the home's folder client-orders. A unit that is in the queue is not ordered again.
    """
    from flows.orders.order_files import scanned
    from flows.orders.production import give

    person, given, refused = options.person(by), [], 0
    for line in filter(str.strip, sys.stdin):
        try:
            given.append(give(scanned(line, station, home()), person, home()))
        except Unusable as fault:
            refused += 1
            print(fault, file=sys.stderr, flush=True)
        else:
            if not as_json:
                _print_given(given[-1:], as_json=False)
    if as_json:
        _print_given(given, as_json)
    if refused:
        raise Unusable(f"lines that were refused: {refused}; scan them again as said above")


@app.command(name="list", epilog="Example: mimucal order list --station LINE-1")
def list_(
    station: options.StationId = None,
    state: options.OrderState = None,
    as_json: options.Json = False,
) -> None:
    """List the orders, the oldest first, and what became of them."""
    from flows.terminal import print_rows
    from schemas.orders import OrdersQuestion, ProductionOrders, order_of
    from storage.catalogue import orders

    asked = order_of(OrdersQuestion, station=station, state=state)
    states = [asked.state] if asked.state else []
    found = orders.listed(home(), asked.station, states, None if as_json else SHOWN)
    if as_json:
        print(ProductionOrders(orders=tuple(found)).model_dump_json(indent=1))
        return
    rows = [
        (
            each.number, each.station, each.serials, each.procedure, each.state, each.person,
            f"{each.ordered_at:%F %R}", each.fault or ", ".join(each.certificates),
        )
        for each in found
    ]  # fmt: skip
    names = (
        "number",
        "station",
        "unit",
        "procedure",
        "state",
        "person",
        "ordered (UTC)",
        "outcome",
    )
    print_rows("Orders", names, rows)


@app.command(epilog="Example: mimucal order cancel 4711")
def cancel(
    number: options.GivenNumber, by: options.By = None, as_json: options.Json = False
) -> None:
    """Cancel an order that waits."""
    from flows.orders.production import QueuedOrder
    from flows.orders.production import cancel as cancel_order

    order = cancel_order(number, options.person(by), home())
    _print_given([QueuedOrder(order, is_new=False)], as_json)


@app.command(epilog="Example: mimucal order retry 4711")
def retry(
    number: options.GivenNumber,
    by: options.By = None,
    reason: options.Reason = None,
    as_json: options.Json = False,
) -> None:
    """Carry out an order again that failed or was cancelled.

    What it measured counts: an interrupted run goes on, and a run that is in the store is not
    repeated unless it is invalid: then the order's units are measured again under its number.
    """
    from flows.orders.production import retry as retry_order

    _print_given([retry_order(number, options.person(by), home(), reason)], as_json)


def _print_given(given: "Sequence[QueuedOrder]", as_json: bool) -> None:
    from schemas.orders import GivenOrders

    faults = sorted({each.fault for each in given if each.fault})
    if as_json:
        document = GivenOrders(
            orders=tuple(each.order for each in given),
            new=tuple(each.order.number for each in given if each.is_new),
            fault="; ".join(faults) or None,
        )
        print(document.model_dump_json(indent=1))
    else:
        for each in given:
            order, there = each.order, "" if each.is_new else " (it was there before)"
            shown = f"{order.serials} by {order.procedure} on {order.station}: {order.state}"
            print(f"order {order.number}: {shown}{there * (order.state == 'waiting')}", flush=True)
    for fault in faults:
        print(fault, file=sys.stderr)
