"""Production orders: which unit is measured on which station, by which procedure, for whom.

`OrderRequest` is what a person or a manufacturing system asks for, as JSON or as a row of a CSV
file; `ProductionOrder` is the order as the catalogue keeps it, with what became of it.
"""

from pathlib import PurePath
from typing import Annotated, Literal

from pydantic import AfterValidator, AwareDatetime, Field

from schemas.base import Frozen
from schemas.certificate import Order
from schemas.recording import Unit
from schemas.text import Statement

# Visible characters, with spaces between them: what a label, a scanner or a form can give.
Name = Annotated[
    str, Field(min_length=1, max_length=100, pattern=r"^[^\p{C}\p{Z}]([^\p{C}]*[^\p{C}\p{Z}])?$")
]


def _is_serial(text: str) -> str:
    """Refuses markup, and what has neither letter nor digit, as dots."""
    if MARKUP & set(text) or not any(sign.isalnum() for sign in text):
        raise ValueError("a serial number has a letter or a digit, and none of < > & \" ' ` \\")
    return text


MARKUP = set("<>&\"'`\\")
Serial = Annotated[Name, AfterValidator(_is_serial)]
ProductionState = Literal["waiting", "running", "done", "failed", "cancelled"]
OPEN: tuple[ProductionState, ...] = ("waiting", "running")
ENDED: tuple[ProductionState, ...] = ("done", "failed", "cancelled")


class OrderedUnit(Frozen):
    """A unit by its serial number.

    manufacturer, model: null means those of the station file's unit at the same place.
    """

    serial: Serial
    manufacturer: Name | None = None
    model: Name | None = None


class OrderRequest(Frozen):
    """An order as submitted.

    number: by which the order is known; the same content under the same number is the same order.
    Null: one is generated. station: its id. units: those to be mounted, in the order of the
    station's places. procedure: a name, or a file of the station's computer. client_order: the
    client's order, which the certificate needs.
    """

    number: Name | None = None
    station: Name
    units: tuple[OrderedUnit, ...] = Field(min_length=1, max_length=64)
    procedure: str = Field(default="jjf2003", min_length=1, max_length=1000)
    client_order: Order | None = None


class RetriedOrder(Frozen):
    """An order that failed or was cancelled is to be carried out again, and why."""

    number: Name
    reason: str | None = Field(default=None, max_length=1000)


class ProductionOrder(Frozen):
    """An order of the catalogue, and what became of it.

    person: who ordered. is_interrupted: a run of it has begun and not ended; whoever takes it next
    goes on with that run. attempts: how often it was begun. submissions: how often it was given to
    Prefect; flow_run: the last of them, null where there is none that counts. host, process: where
    it was begun last. runs, certificates: ids and keys of drafts, in the order of the units. fault:
    why it failed; of one that waits, what keeps it from beginning; cause: the same for the pages.
    """

    number: str
    station: str
    units: tuple[Unit, ...]
    procedure: str
    client_order: Order | None = None
    person: str
    ordered_at: AwareDatetime
    state: ProductionState = "waiting"
    is_interrupted: bool = False
    attempts: int = 0
    submissions: int = 0
    flow_run: str | None = None
    host: str | None = None
    process: int | None = None
    began_at: AwareDatetime | None = None
    ended_at: AwareDatetime | None = None
    runs: tuple[str, ...] = ()
    certificates: tuple[str, ...] = ()
    fault: str | None = None
    cause: Statement | None = None

    @property
    def serials(self) -> str:
        """The serial numbers of its units, as they are shown."""
        return ", ".join(unit.serial for unit in self.units)

    @property
    def title(self) -> str:
        """Its units and its procedure, as its flow run is called."""
        return f"{self.serials} {PurePath(self.procedure).stem}"

    def differs_from(self, other: "ProductionOrder") -> str | None:
        """In what another order asks for something else, whoever ordered and whenever."""
        for name in ("station", "units", "procedure", "client_order"):
            if getattr(self, name) != getattr(other, name):
                return name.replace("_", " ")
        return None


class ProductionOrders(Frozen):
    """Orders as the command line and the pages list them, the oldest first."""

    format: Literal["mimu-orders/1"] = "mimu-orders/1"
    orders: tuple[ProductionOrder, ...]


class GivenOrders(ProductionOrders):
    """Orders that were given. new: the numbers of those that were not there before. fault: why one
    of them cannot be carried out at present; it waits.
    """

    new: tuple[str, ...] = ()
    fault: str | None = None


class OrdersQuestion(Frozen):
    """Which orders are listed: those of a station, those in a state; null: all."""

    station: str | None = None
    state: ProductionState | None = None


class QualityFile(Frozen):
    """`quality.toml` of the home: what the laboratory says of its production.

    golden: serial numbers of units that are measured again and again to check the stations. They
    are not production: they are excluded from yield and capability.
    """

    format: Literal["mimu-quality/1"] = "mimu-quality/1"
    golden: tuple[str, ...] = ()
