"""What an endpoint answers where it gives nothing."""

from schemas.base import Frozen


class Unanswered(Frozen):
    """Why there is no answer, as one sentence."""

    error: str
