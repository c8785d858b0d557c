"""The JSON and the files of the pages: `/api/v1`, its description, and orders by it."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flask import Blueprint, Response, request
from pydantic.json_schema import models_json_schema
from werkzeug.exceptions import HTTPException

from flows.orders import production
from flows.pages import discrepancy, do, due, line, quality, run, runs, unit
from flows.pages.do import check_may
from flows.pages.line_data import (
    Acknowledged,
    AlarmPressed,
    Released,
    StopPressed,
    StopShown,
    acknowledge,
    let_go_on,
    press,
)
from flows.pages.parts import (
    Page,
    Row,
    Unanswered,
    View,
    csv_of,
    json_answer,
    refusal,
    refuse_what_is_raised,
    seen_by,
    view,
)
from flows.pages.run_data import pdf_of
from schemas.access import Visitor
from schemas.base import Frozen, NotThere, Unusable
from schemas.orders import (
    OrderRequest,
    OrdersQuestion,
    ProductionOrder,
    ProductionOrders,
    RetriedOrder,
)
from storage.catalogue import orders
from storage.catalogue.discrepancies import report_of
from storage.catalogue.runs import find
from storage.home import Home
from tasks.station import procedures
from tasks.version import code_version

# All pages, in the order of the navigation.


PAGES: tuple[Page, ...] = (
    line.PAGE,
    runs.PAGE,
    run.PAGE,
    run.SIGNALS_PAGE,
    run.BUDGET_PAGE,
    unit.PAGE,
    due.PAGE,
    quality.PAGE,
    discrepancy.PAGE,
    do.PAGE,
)
FIRST = PAGES[0]  # what the bare address shows


# /api/v1/orders: a manufacturing system gives orders, and sees what became of them.

LONGEST = 1_000_000  # bytes of an order


def listed(home: Home) -> Response:
    """The orders of a station, or in a state; else all."""
    asked = OrdersQuestion.model_validate(request.args.to_dict())
    found = orders.listed(home, asked.station, [asked.state] if asked.state else [])
    return json_answer(ProductionOrders(orders=tuple(found)).model_dump_json())


def retry(asked: RetriedOrder, visitor: Visitor, home: Home) -> ProductionOrder:
    """Have an order carried out again that failed or was cancelled."""
    check_may("acquire", visitor, asked.number, home)
    return production.retry(asked.number, visitor.name, home, asked.reason).order


def give(home: Home) -> Response:
    """Keep an order: 201, or 200 where it is there already; it needs a number."""
    visitor = view().visitor
    check_may("acquire", visitor, "*", home)
    if (request.content_length or 0) > LONGEST:
        raise Unusable(f"the order has more than {LONGEST} bytes; give one order at a time")
    asked = OrderRequest.model_validate_json(request.get_data())
    if asked.number is None:
        raise Unusable("number is missing: by it an order that is sent twice is one order")
    procedures.load(asked.procedure)  # and no file of this computer
    given = production.give(asked, visitor.name, home)
    return json_answer(given.order.model_dump_json(), 201 if given.is_new else 200)


# The JSON endpoint of each page, and their OpenAPI description.

PREFIX = "/api/v1"
REFUSALS = {
    400: "The query or document cannot be answered as it stands; every fault of it is named.",
    401: "Nobody said who is asking (HTTP basic authentication, or a session).",
    503: "The catalogue cannot be reached just now.",
}
OF_ROLES = REFUSALS | {403: "The role does not allow it."}
OF_NAMES = OF_ROLES | {404: "There is no such order, station or alarm."}
SENT = (  # documents that act: what they do, and what became of it
    ("retry", "Carry out an order again that failed or was cancelled",
     RetriedOrder, ProductionOrder, retry),
    ("stop", "Stop a station's table now", StopPressed, StopShown, press),
    ("release", "Let the orders of a stopped station go on", StopPressed, Released, let_go_on),
    ("acknowledge", "Say that somebody saw to an alarm",
     AlarmPressed, Acknowledged, acknowledge),
)  # fmt: skip
REFERENCE = "#/components/schemas/{model}"


def endpoints(home: Home) -> Blueprint:
    """GET /api/v1/NAME for each page, NAME/PART.csv for its numbers, orders and openapi.json."""
    made = Blueprint("api", __name__, url_prefix=PREFIX)
    refuse_what_is_raised(made)
    for page in PAGES:
        made.add_url_rule(f"/{page.name}", page.name, _answering(page, home), methods=["GET"])
        for part, rows in page.numbers.items():
            answer = _answering(page, home, rows)
            made.add_url_rule(f"/{page.name}/{part}.csv", f"{page.name}-{part}", answer)
    made.add_url_rule("/orders", "orders", lambda: listed(home), methods=["GET"])
    made.add_url_rule("/orders", "order", lambda: give(home), methods=["POST"])
    for name, _, takes, _, act in SENT:
        made.add_url_rule(f"/{name}", name, _acting(takes, act, home), methods=["POST"])
    made.add_url_rule("/openapi.json", "openapi", lambda: json_answer(json.dumps(openapi())))
    return made


def unknown_address() -> Response | None:
    """A refusal of what would else be one of Dash's pages, before a request is answered."""
    rule, fault = request.url_rule, request.routing_exception
    if isinstance(fault, HTTPException) and fault.code not in (404, 405):
        return None  # as of another host's name
    if f"{request.path}/".startswith(f"{PREFIX}/") and not (rule and rule.rule.startswith(PREFIX)):
        return refusal(404, f"there is nothing here; {PREFIX}/openapi.json says what there is")
    return None


def _answering(
    page: Page, home: Home, rows: Callable[[Any], Sequence[Row]] | None = None
) -> Callable[[], Response]:
    """Answers as JSON; with rows, with those of them as CSV."""

    def answer() -> Response:
        found = page.data(page.question.model_validate(request.args.to_dict()), home)
        if rows is not None:
            attached = {"Content-Disposition": "attachment"}
            return Response(csv_of(rows(found)), mimetype="text/csv", headers=attached)
        return json_answer(found.model_dump_json())

    return answer


def _acting(
    takes: type[Frozen], act: Callable[[Any, Visitor, Home], Frozen], home: Home
) -> Callable[[], Response]:
    """Does what a document asks for, in the name of whoever is logged in."""

    def answer() -> Response:
        asked = takes.model_validate_json(request.get_data())
        try:
            return json_answer(act(asked, view().visitor, home).model_dump_json())
        except NotThere as fault:
            return refusal(404, str(fault))

    return answer


def openapi() -> dict[str, Any]:
    """The description of all endpoints (OpenAPI 3.1), made of the models of the pages."""
    paths: dict[str, dict[str, Any]] = {}
    for page in PAGES:
        about = seen_by(View(), page.about)  # in English, whoever asks
        address = f"{PREFIX}/{page.name}"
        shown = {200: ("What the page shows.", page.answer)}
        paths[address] = {"get": _operation(page.name, about, shown, asks=page.question)}
        for part in page.numbers:
            name, what = f"{page.name}-{part}", f"{about}, {part} as CSV"
            rows = {200: ("A row for each.", None)}
            paths[f"{address}/{part}.csv"] = {
                "get": _operation(name, what, rows, asks=page.question)
            }
    listed = {200: ("The orders.", ProductionOrders)}
    given = {
        201: ("The order is in the queue of its station.", ProductionOrder),
        200: ("It was there already: the same content under the same number.", ProductionOrder),
    }
    paths[f"{PREFIX}/orders"] = {
        "get": _operation(
            "orders", "Production orders, the oldest first, and what became of them", listed,
            asks=OrdersQuestion,
        ),
        "post": _operation(
            "order", "Order the calibration of a unit, by HTTP basic authentication", given,
            OF_ROLES, takes=OrderRequest,
        ),
    }  # fmt: skip
    for name, what, takes, answer, _ in SENT:
        became = {200: ("What became of it.", answer)}
        sent = _operation(name, what, became, OF_NAMES, takes=takes)
        paths[f"{PREFIX}/{name}"] = {"post": sent}
    answers = [page.answer for page in PAGES] + [each[3] for each in SENT]
    answers += [ProductionOrders, ProductionOrder, Unanswered]
    models: list[tuple[type[Frozen], Any]] = [(model, "serialization") for model in answers]
    models += [(model, "validation") for model in (OrderRequest, *(each[2] for each in SENT))]
    _, schemas = models_json_schema(models, ref_template=REFERENCE)
    return {
        "openapi": "3.1.0",
        "info": {"title": "mimucal", "version": code_version()},
        "paths": paths,
        "components": {"schemas": schemas["$defs"]},
    }


def _operation(
    name: str,
    summary: str,
    answers: Mapping[int, tuple[str, type[Frozen] | None]],
    refusals: Mapping[int, str] = REFUSALS,
    *,
    asks: type[Frozen] | None = None,
    takes: type[Frozen] | None = None,
) -> dict[str, Any]:
    """asks: the model of the query; takes: that of the document. An answer without is CSV."""
    schema = asks.model_json_schema() if asks else {}
    refused = {status: (text, Unanswered) for status, text in refusals.items()}
    described: dict[str, Any] = {
        "operationId": name,
        "summary": summary,
        "parameters": [
            {"name": name, "in": "query", "required": name in schema.get("required", ()),
             "schema": field}
            for name, field in schema.get("properties", {}).items()
        ],
        "responses": {
            str(status): {"description": text, "content": _content(model)}
            for status, (text, model) in {**answers, **refused}.items()
        },
    }  # fmt: skip
    if takes:
        described["requestBody"] = {"required": True, "content": _content(takes)}
    return described


def _content(model: type[Frozen] | None) -> dict[str, Any]:
    if model is None:
        return {"text/csv": {"schema": {"type": "string"}}}
    return {"application/json": {"schema": {"$ref": REFERENCE.format(model=model.__name__)}}}


# Serves stored files: the PDF of a certificate, the report of an explained run.


def files(home: Home) -> Blueprint:
    """GET /certificate/NUMBER.pdf and /explained/RUN.html."""
    made = Blueprint("files", __name__)

    @made.get("/certificate/<number>.pdf")
    def certificate(number: str) -> Response:
        try:
            name, content = pdf_of(number, home)
        except Unusable as error:
            return Response(str(error), 404, mimetype="text/plain")
        disposition = {"Content-Disposition": f'inline; filename="{name}"'}
        return Response(content, mimetype="application/pdf", headers=disposition)

    @made.get("/explained/<run>.html")
    def explained(run: str) -> Response:
        try:
            report = report_of(find(run, home), home)
        except Unusable as error:
            return Response(str(error), 404, mimetype="text/plain")
        if report is None:
            return Response(f"Run {run} was not explained yet.", 404, mimetype="text/plain")
        return Response(report, mimetype="text/html")

    return made
