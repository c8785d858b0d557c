"""Answers in JSON, and refusals with their reason."""

from flask import Blueprint, Response
from pydantic import ValidationError

from schemas.base import Frozen, NotAllowed, Unusable, faults
from storage.catalogue.connection import Busy

STATUS = {NotAllowed: 403, Busy: 503}  # of a refusal; of any other 400


class Unanswered(Frozen):
    """Why there is no answer, as one sentence."""

    error: str


def refusal(status: int, sentence: str) -> Response:
    """An answer that gives nothing but the reason."""
    return json_answer(Unanswered(error=sentence).model_dump_json(), status)


def json_answer(text: str, status: int = 200) -> Response:
    """A document as an answer."""
    return Response(text, status, mimetype="application/json")


def refuse_what_is_raised(made: Blueprint) -> None:
    """Has each address of a blueprint answer with what it raises: every fault of a document, or the
    one sentence.
    """
    made.register_error_handler(
        ValidationError, lambda error: refusal(400, "; ".join(faults(error)))
    )
    made.register_error_handler(
        Unusable, lambda error: refusal(STATUS.get(type(error), 400), str(error))
    )
