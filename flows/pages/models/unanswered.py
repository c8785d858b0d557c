"""The answer of an endpoint that has nothing to give."""

from schemas.base import Frozen


class Unanswered(Frozen):
    """Why there is no answer, as one sentence."""

    error: str
