"""Answers in JSON, and refusals with their reason."""

from flask import Response

from schemas.base import Frozen


class Unanswered(Frozen):
    """Why there is no answer, as one sentence."""

    error: str


def refusal(status: int, sentence: str) -> Response:
    """An answer that gives nothing but the reason."""
    return json_answer(Unanswered(error=sentence).model_dump_json(), status)


def json_answer(text: str, status: int = 200) -> Response:
    """A document as an answer."""
    return Response(text, status, mimetype="application/json")
