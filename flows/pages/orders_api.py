"""/api/v1/orders: a manufacturing system gives orders, and sees what became of them."""

from flask import Response, request

from flows.orders import order_queue
from flows.pages.do.orders import check_may
from flows.pages.json_answers import json_answer
from flows.pages.page import view_of_request
from schemas.access import Visitor
from schemas.base import Unusable
from schemas.production import (
    OrderRequest,
    OrdersQuestion,
    ProductionOrder,
    ProductionOrders,
    RetriedOrder,
)
from storage.catalogue import orders
from storage.home import Home
from tasks.station import procedures

LONGEST = 1_000_000  # bytes of an order


def listed(home: Home) -> Response:
    """The orders of a station, or in a state; else all."""
    asked = OrdersQuestion.model_validate(request.args.to_dict())
    found = orders.listed(home, asked.station, [asked.state] if asked.state else [])
    return json_answer(ProductionOrders(orders=tuple(found)).model_dump_json())


def retry(asked: RetriedOrder, visitor: Visitor, home: Home) -> ProductionOrder:
    """Have an order carried out again that failed or was cancelled."""
    check_may("acquire", visitor, asked.number, home)
    return order_queue.retry(asked.number, visitor.name, home, asked.reason).order


def give(home: Home) -> Response:
    """Keep an order: 201, or 200 where it is there already; it needs a number."""
    visitor = view_of_request().visitor
    check_may("acquire", visitor, "*", home)
    if (request.content_length or 0) > LONGEST:
        raise Unusable(f"the order has more than {LONGEST} bytes; give one order at a time")
    asked = OrderRequest.model_validate_json(request.get_data())
    if asked.number is None:
        raise Unusable("number is missing: by it an order that is sent twice is one order")
    procedures.load(asked.procedure)  # and no file of this computer
    given = order_queue.give(asked, visitor.name, home)
    return json_answer(given.order.model_dump_json(), 201 if given.is_new else 200)
