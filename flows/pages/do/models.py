"""What can be ordered from the pages, and what became of it."""

from collections.abc import Mapping
from typing import Literal

from pydantic import AwareDatetime

from schemas.access import Action
from schemas.base import Finite, Frozen
from schemas.certificate import State
from schemas.production import ProductionOrder

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
    """What there is to choose from, the queue of the stations, and the other orders given here.

    stations: ids. client_orders, tolerances: names of the home's files. production: the orders that
    wait or run, and the last ones that ended, the oldest first. progress: the share that is done of
    the run that goes on at a station.
    """

    stations: tuple[str, ...]
    procedures: tuple[str, ...]
    client_orders: tuple[str, ...]
    tolerances: tuple[str, ...]
    production: tuple[ProductionOrder, ...]
    progress: Mapping[str, Finite] = {}
    certificates: tuple[WaitingCertificate, ...]
    orders: tuple[GivenOrder, ...]
