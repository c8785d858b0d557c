"""The JSON endpoint of each page, and their OpenAPI description."""

import json
from collections.abc import Callable, Sequence
from typing import Any

from flask import Blueprint, Response, request
from pydantic import ValidationError
from pydantic.json_schema import models_json_schema

from flows.pages.numbers import Row, csv_of
from flows.pages.page import Page, View
from flows.pages.register import PAGES
from schemas.base import Frozen, Unusable, first_fault
from schemas.pages.unanswered import Unanswered
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
    """GET /api/v1/NAME for each page, /api/v1/NAME/PART.csv for its numbers, and openapi.json."""
    made = Blueprint("api", __name__, url_prefix=PREFIX)
    for page in PAGES:
        made.add_url_rule(f"/{page.name}", page.name, _answering(page, home), methods=["GET"])
        for part, rows in page.numbers.items():
            answer = _answering(page, home, rows)
            made.add_url_rule(f"/{page.name}/{part}.csv", f"{page.name}-{part}", answer)
    made.add_url_rule("/openapi.json", "openapi", lambda: _json(json.dumps(openapi())))
    return made


def _answering(
    page: Page, home: Home, rows: Callable[[Any], Sequence[Row]] | None = None
) -> Callable[[], Response]:
    """Answers as JSON; with rows, with those of them as CSV."""

    def answer() -> Response:
        try:
            question = page.question.model_validate(request.args.to_dict())
            found = page.data(question, home)
            return _json(found.model_dump_json()) if rows is None else _csv(csv_of(rows(found)))
        except ValidationError as error:
            return refusal(400, first_fault(error))
        except Busy as error:
            return refusal(503, str(error))
        except Unusable as error:
            return refusal(400, str(error))

    return answer


def refusal(status: int, sentence: str) -> Response:
    """An answer that gives nothing but the reason."""
    return _json(Unanswered(error=sentence).model_dump_json(), status)


def _csv(text: str) -> Response:
    disposition = {"Content-Disposition": "attachment"}
    return Response(text, mimetype="text/csv", headers=disposition)


def _json(text: str, status: int = 200) -> Response:
    return Response(text, status, mimetype="application/json")


def openapi() -> dict[str, Any]:
    """The description of all endpoints (OpenAPI 3.1), made of the models of the pages."""
    models: list[tuple[type[Frozen], Any]] = [(page.answer, "serialization") for page in PAGES]
    _, schemas = models_json_schema(
        [*models, (Unanswered, "serialization")], ref_template="#/components/schemas/{model}"
    )
    return {
        "openapi": "3.1.0",
        "info": {"title": "mimucal", "version": code_version()},
        "paths": {f"{PREFIX}/{page.name}": {"get": _operation(page)} for page in PAGES},
        "components": {"schemas": schemas["$defs"]},
    }


def _operation(page: Page) -> dict[str, Any]:
    refused = {
        str(status): {"description": text, "content": _content(Unanswered)}
        for status, text in REFUSALS.items()
    }
    given = {"200": {"description": "What the page shows.", "content": _content(page.answer)}}
    return {
        "operationId": page.name,
        "summary": page.about(View()),
        "parameters": list(_parameters(page.question)),
        "responses": given | refused,
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
