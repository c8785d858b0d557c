"""The base of every model, and errors that are addressed to the user."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from schemas.secret_urls import shown

Finite = Annotated[float, Field(allow_inf_nan=False)]


class Frozen(BaseModel):
    """An immutable model that refuses fields it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Worded(Exception):  # noqa: N818 (its kinds say what is wrong)
    """A sentence for the terminal.

    cause: the same as a message or statement for the pages, which show neither commands of a shell
    nor places of the server; null where only the sentence exists.
    """

    def __init__(self, sentence: str = "", cause: object = None) -> None:
        super().__init__(sentence)
        self.cause = cause


class Unusable(Worded):
    """Input that cannot be used.

    The text is one sentence for the person at the bench: the file, the field, the value and
    the way out. The command line prints it and exits with 2.
    """


class NotThere(Unusable):
    """What is named does not exist."""


class NotAllowed(Unusable):
    """The role of whoever asks does not allow it."""


class BrokenOff(Worded):
    """The operator or the machine ended a run; the sentence says where its recording is."""


def first_fault(error: ValidationError) -> str:
    """The first fault of a validation error as “field.path: what is wrong (found value)”."""
    return faults(error)[0]


def faults(error: ValidationError) -> list[str]:
    """Every fault of a validation error as `first_fault` has it."""
    return list(map(_fault, error.errors(include_url=False)))


def _fault(fault: ErrorDetails) -> str:
    place = ".".join(str(part) for part in fault["loc"]) or "document"
    if fault["type"] == "missing":
        return f"{place} is missing"
    message = fault["msg"].removeprefix("Value error, ")
    value = fault.get("input")
    value = shown(value) if isinstance(value, str) else value
    found = "" if isinstance(value, dict) else f" (found {value!r})"[:80]
    return f"{place}: {message}{found}"
