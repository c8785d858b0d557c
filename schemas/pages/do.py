"""What can be ordered from the pages, and what became of it."""

from typing import Literal

from pydantic import AwareDatetime

from schemas.access import Action
from schemas.base import Frozen
from schemas.certificate import State

OrderState = Literal["running", "done", "failed"]


class DoQuestion(Frozen):
    """A run or a certificate that the forms begin with."""

    run: str | None = None
    certificate: str | None = None


class WaitingCertificate(Frozen):
    """A certificate whose next step is to be taken, or that may be withdrawn."""

    number: str
    state: State
    unit: str


class GivenOrder(Frozen):
    """An order given here since the pages are served; fault: its last line where it failed."""

    action: Action
    subject: str
    person: str
    at: AwareDatetime
    state: OrderState
    fault: str = ""


class DoShown(Frozen):
    """Station files of the home, procedures, certificates that wait, and the orders given here."""

    stations: tuple[str, ...]
    procedures: tuple[str, ...]
    certificates: tuple[WaitingCertificate, ...]
    orders: tuple[GivenOrder, ...]
