"""/api/v1/orders: a manufacturing system gives orders, and sees what became of them."""

from flask import Response, g, request
from pydantic import ValidationError

from flows.orders import order_queue
from flows.pages.do.orders import check_may
from flows.pages.json_answers import json_answer, refusal
from schemas.access import Visitor
from schemas.base import NotThere, Unusable, first_fault
from schemas.production import OrderRequest, OrdersQuestion, ProductionOrders, RetriedOrder
from storage.catalogue import orders
from storage.catalogue.connection import Busy
from storage.home import Home
from tasks.station import procedures

LONGEST = 1_000_000  # bytes of an order


def listed(home: Home) -> Response:
    """The orders of a station, or in a state; else all."""
    try:
        asked = OrdersQuestion.model_validate(request.args.to_dict())
        states = [asked.state] if asked.state else []
        found = orders.listed(home, asked.station, states)
    except ValidationError as error:
        return refusal(400, first_fault(error))
    except Busy as error:
        return refusal(503, str(error))
    return json_answer(ProductionOrders(orders=tuple(found)).model_dump_json())


def retry(home: Home) -> Response:
    """Have an order carried out again that failed or was cancelled: 404 for an unknown number."""
    visitor: Visitor = g.get("visitor") or Visitor()
    try:
        check_may("acquire", visitor, "*", home)
    except Unusable as error:
        return refusal(403, str(error))
    try:
        asked = RetriedOrder.model_validate_json(request.get_data())
        given = order_queue.retry(asked.number, visitor.name, home, asked.reason)
    except ValidationError as error:
        return refusal(400, first_fault(error))
    except Busy as error:
        return refusal(503, str(error))
    except Unusable as error:
        return refusal(404 if isinstance(error, NotThere) else 400, str(error))
    return json_answer(given.order.model_dump_json())


def give(home: Home) -> Response:
    """Keep an order: 201, or 200 where it is there already; it needs a number."""
    visitor: Visitor = g.get("visitor") or Visitor()
    try:
        check_may("acquire", visitor, "*", home)
    except Unusable as error:
        return refusal(403, str(error))
    try:
        if (request.content_length or 0) > LONGEST:
            raise Unusable(f"the order has more than {LONGEST} bytes; give one order at a time")
        asked = OrderRequest.model_validate_json(request.get_data())
        if asked.number is None:
            raise Unusable("number is missing: by it an order that is sent twice is one order")
        procedures.load(asked.procedure)  # and no file of this computer
        given = order_queue.give(asked, visitor.name, home)
    except ValidationError as error:
        faults = error.errors(include_url=False, include_input=False)
        named = (f"{'.'.join(map(str, at['loc'])) or 'document'}: {at['msg']}" for at in faults)
        return refusal(400, "; ".join(named))
    except Busy as error:
        return refusal(503, str(error))
    except Unusable as error:
        return refusal(400, str(error))
    return json_answer(given.order.model_dump_json(), 201 if given.is_new else 200)
