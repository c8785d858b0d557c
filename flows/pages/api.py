"""The JSON endpoint of each page, and their OpenAPI description."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flask import Blueprint, Response, request
from pydantic import ValidationError
from pydantic.json_schema import models_json_schema

from flows.pages import orders_api
from flows.pages.json_answers import json_answer, refusal
from flows.pages.models.line import Released, StopPressed, StopShown
from flows.pages.models.unanswered import Unanswered
from flows.pages.numbers import Row, csv_of
from flows.pages.page import Page, View
from flows.pages.register import PAGES
from schemas.base import Frozen, Unusable, first_fault
from schemas.production import OrderRequest, OrdersQuestion, ProductionOrder, ProductionOrders
from storage.catalogue.connection import Busy
from storage.home import Home
from tasks.version import code_version

PREFIX = "/api/v1"
REFUSALS = {
    400: "The query cannot be answered as it stands.",
    401: "Nobody said who is asking (HTTP basic authentication, or a session).",
    503: "The catalogue cannot be reached just now.",
}


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
    made.add_url_rule("/openapi.json", "openapi", lambda: json_answer(json.dumps(openapi())))
    return made


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
    models: list[tuple[type[Frozen], Any]] = [(page.answer, "serialization") for page in PAGES]
    of_acts: list[tuple[type[Frozen], Any]] = [
        (OrderRequest, "validation"), (ProductionOrder, "serialization"),
        (ProductionOrders, "serialization"), (StopPressed, "validation"),
        (StopShown, "serialization"), (Released, "serialization"),
    ]  # fmt: skip
    _, schemas = models_json_schema(
        [*models, *of_acts, (Unanswered, "serialization")],
        ref_template="#/components/schemas/{model}",
    )
    return {
        "openapi": "3.1.0",
        "info": {"title": "mimucal", "version": code_version()},
        "paths": {f"{PREFIX}/{page.name}": {"get": _operation(page)} for page in PAGES}
        | {
            f"{PREFIX}/{page.name}/{part}.csv": {"get": _numbers(page, part)}
            for page in PAGES
            for part in page.numbers
        }
        | {
            f"{PREFIX}/orders": {"get": _orders_listed(), "post": _order_given()},
            f"{PREFIX}/stop": {"post": _pressed("stop", "Stop a station's table now", StopShown)},
            f"{PREFIX}/release": {
                "post": _pressed("release", "Let the orders of a stopped station go on", Released)
            },
        },
        "components": {"schemas": schemas["$defs"]},
    }


def _operation(page: Page) -> dict[str, Any]:
    return {
        "operationId": page.name,
        "summary": page.about(View()),
        "parameters": list(_parameters(page.question)),
        "responses": _answers({200: ("What the page shows.", page.answer)}, REFUSALS),
    }


def _numbers(page: Page, part: str) -> dict[str, Any]:
    """A table or chart of a page as CSV."""
    refused = _answers({}, REFUSALS)
    text = {"text/csv": {"schema": {"type": "string"}}}
    return {
        "operationId": f"{page.name}-{part}",
        "summary": f"{page.about(View())}, {part} as CSV",
        "parameters": list(_parameters(page.question)),
        "responses": {"200": {"description": "A row for each.", "content": text}} | refused,
    }


def _pressed(name: str, summary: str, answer: type[Frozen]) -> dict[str, Any]:
    """What is pressed on the card of a station."""
    refused = {400: "The document names no station.", 403: "The role does not allow it.",
               401: REFUSALS[401]}  # fmt: skip
    return {
        "operationId": name,
        "summary": summary,
        "requestBody": {"required": True, "content": _content(StopPressed)},
        "responses": _answers({200: ("What became of it.", answer)}, refused),
    }


def _orders_listed() -> dict[str, Any]:
    return {
        "operationId": "orders",
        "summary": "Production orders, the oldest first, and what became of them",
        "parameters": list(_parameters(OrdersQuestion)),
        "responses": _answers({200: ("The orders.", ProductionOrders)}, REFUSALS),
    }


def _order_given() -> dict[str, Any]:
    given = {
        201: ("The order is in the queue of its station.", ProductionOrder),
        200: ("It was there already: the same content under the same number.", ProductionOrder),
    }
    refused = REFUSALS | {
        400: "The order cannot be carried out; every fault of the document is named.",
        403: "The role does not allow orders.",
    }
    return {
        "operationId": "order",
        "summary": "Order the calibration of a unit, by HTTP basic authentication",
        "requestBody": {"required": True, "content": _content(OrderRequest)},
        "responses": _answers(given, refused),
    }


def _answers(
    given: Mapping[int, tuple[str, type[Frozen]]], refused: Mapping[int, str]
) -> dict[str, Any]:
    every: dict[int, tuple[str, type[Frozen]]] = {**given} | {
        status: (text, Unanswered) for status, text in refused.items()
    }
    return {
        str(status): {"description": text, "content": _content(model)}
        for status, (text, model) in every.items()
    }


def _parameters(question: type[Frozen]) -> list[dict[str, Any]]:
    schema = question.model_json_schema()
    required = schema.get("required", ())
    return [
        {"name": name, "in": "query", "required": name in required, "schema": field}
        for name, field in schema.get("properties", {}).items()
    ]


def _content(model: type[Frozen]) -> dict[str, Any]:
    reference = {"$ref": f"#/components/schemas/{model.__name__}"}
    return {"application/json": {"schema": reference}}
