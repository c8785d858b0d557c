"""The JSON endpoint of each page, and their OpenAPI description."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flask import Blueprint, Response, request
from pydantic import ValidationError
from pydantic.json_schema import models_json_schema
from werkzeug.exceptions import HTTPException

from flows.pages import orders_api
from flows.pages.json_answers import Unanswered, json_answer, refusal
from flows.pages.line.models import (
    Acknowledged,
    AlarmPressed,
    Released,
    StopPressed,
    StopShown,
)
from flows.pages.numbers import Row, csv_of
from flows.pages.page import Page, View
from flows.pages.register import PAGES
from schemas.base import Frozen, Unusable, first_fault
from schemas.production import (
    OrderRequest,
    OrdersQuestion,
    ProductionOrder,
    ProductionOrders,
    RetriedOrder,
)
from storage.catalogue.connection import Busy
from storage.home import Home
from tasks.version import code_version

PREFIX = "/api/v1"
REFUSALS = {
    400: "The query cannot be answered as it stands.",
    401: "Nobody said who is asking (HTTP basic authentication, or a session).",
    503: "The catalogue cannot be reached just now.",
}
PRESS_REFUSALS = {
    400: "The document names neither station nor alarm.",
    404: "There is no such station or alarm.",
    403: "The role does not allow it.",
    401: REFUSALS[401],
}
PRESSES = (  # on the card of a station
    ("stop", "Stop a station's table now", StopShown, StopPressed),
    ("release", "Let the orders of a stopped station go on", Released, StopPressed),
    ("acknowledge", "Say that somebody saw to an alarm", Acknowledged, AlarmPressed),
)
REFERENCE = "#/components/schemas/{model}"


def endpoints(home: Home) -> Blueprint:
    """GET /api/v1/NAME for each page, NAME/PART.csv for its numbers, orders and openapi.json."""
    made = Blueprint("api", __name__, url_prefix=PREFIX)
    for page in PAGES:
        made.add_url_rule(f"/{page.name}", page.name, _answering(page, home), methods=["GET"])
        for part, rows in page.numbers.items():
            answer = _answering(page, home, rows)
            made.add_url_rule(f"/{page.name}/{part}.csv", f"{page.name}-{part}", answer)
    made.add_url_rule("/orders", "orders", lambda: orders_api.listed(home), methods=["GET"])
    made.add_url_rule("/orders", "order", lambda: orders_api.give(home), methods=["POST"])
    made.add_url_rule("/retry", "retry", lambda: orders_api.retry(home), methods=["POST"])
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
        try:
            question = page.question.model_validate(request.args.to_dict())
            found = page.data(question, home)
            if rows is not None:
                attached = {"Content-Disposition": "attachment"}
                return Response(csv_of(rows(found)), mimetype="text/csv", headers=attached)
            return json_answer(found.model_dump_json())
        except ValidationError as error:
            return refusal(400, first_fault(error))
        except Busy as error:
            return refusal(503, str(error))
        except Unusable as error:
            return refusal(400, str(error))

    return answer


def openapi() -> dict[str, Any]:
    """The description of all endpoints (OpenAPI 3.1), made of the models of the pages."""
    paths: dict[str, dict[str, Any]] = {}
    for page in PAGES:
        about, address = page.about(View()), f"{PREFIX}/{page.name}"
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
    refused = {
        400: "The order cannot be carried out; every fault of the document is named.",
        403: "The role does not allow orders.",
    }
    paths[f"{PREFIX}/orders"] = {
        "get": _operation(
            "orders", "Production orders, the oldest first, and what became of them", listed,
            asks=OrdersQuestion,
        ),
        "post": _operation(
            "order", "Order the calibration of a unit, by HTTP basic authentication", given,
            REFUSALS | refused, takes=OrderRequest,
        ),
    }  # fmt: skip
    again = {200: ("The order waits again.", ProductionOrder)}
    paths[f"{PREFIX}/retry"] = {
        "post": _operation(
            "retry", "Carry out an order again that failed or was cancelled", again,
            REFUSALS | refused | {404: "There is no such order."}, takes=RetriedOrder,
        ),
    }  # fmt: skip
    for name, what, answer, takes in PRESSES:
        became = {200: ("What became of it.", answer)}
        pressed = _operation(name, what, became, PRESS_REFUSALS, takes=takes)
        paths[f"{PREFIX}/{name}"] = {"post": pressed}
    answers: list[type[Frozen]] = [page.answer for page in PAGES]
    answers += [ProductionOrders, ProductionOrder, StopShown, Released, Acknowledged, Unanswered]
    models: list[tuple[type[Frozen], Any]] = [(model, "serialization") for model in answers]
    models += [
        (OrderRequest, "validation"),
        (RetriedOrder, "validation"),
        (StopPressed, "validation"),
        (AlarmPressed, "validation"),
    ]
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
