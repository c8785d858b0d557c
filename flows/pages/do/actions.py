"""What can be ordered from the pages, what became of it, and what the page shows of it."""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import AwareDatetime

from flows import execute
from flows.access_log import UNKNOWN, refused
from flows.orders import production
from flows.orders.order_files import request_of
from flows.orders.signed_orders import carry_out_signed
from schemas.access import MAY, Action, Visitor
from schemas.base import Finite, Frozen, NotAllowed, Unusable
from schemas.certificate import Order, State
from schemas.orders import (
    CheckOrder,
    IssueOrder,
    ProductionOrder,
    ReprocessOrder,
    WithdrawOrder,
    order_of,
)
from storage import settings
from storage.catalogue import audit_trail, certificates, database
from storage.catalogue.runs import find
from storage.home import Home
from storage.whole_files import writing_in_home
from tasks.station import procedures
from tasks.words import Message, message

# What can be ordered from the pages, and what became of it.

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


# Orders given on the pages: checked against the role, then carried out as by the command line.
#
# The steps of a certificate are taken at once. A run goes into the queue of its station. A re-
# processing, a draft and an amendment take minutes: each is a process of the command line with a
# log in the home, and outlives the server of the pages.

LAST_LINE = 500  # characters of the log that a failed order shows
FIELDS: Mapping[Action, tuple[str, ...]] = {  # of each order; whatever else is sent is left out
    "acquire": ("station", "serial", "manufacturer", "model", "procedure", "client_order"),
    "certify": ("run", "client_order", "tolerance", "operator", "report"),
    "check": ("certificate", "reason"),
    "issue": ("certificate", "reason"),
    "amend": ("certificate", "reason", "tolerance"),
    "withdraw": ("certificate", "reason"),
    "reprocess": ("since", "until", "model", "serial", "station"),
}
REQUIRED: Mapping[Action, tuple[str, ...]] = {
    "acquire": ("station", "serial"), "certify": ("run",), "check": ("certificate",),
    "issue": ("certificate",), "amend": ("certificate", "reason"),
    "withdraw": ("certificate", "reason"),
}  # fmt: skip
STEPS: Mapping[Action, tuple[Any, Callable[[Any], Any]]] = {  # of a certificate, taken at once
    "check": (CheckOrder, execute.check), "issue": (IssueOrder, execute.issue),
    "withdraw": (WithdrawOrder, execute.withdraw),
}  # fmt: skip
Fields = Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Running:
    """A process of the command line, and whose order it carries out."""

    action: Action
    subject: str
    person: str
    at: datetime
    process: "subprocess.Popen[bytes]"
    log: Path

    def given(self) -> GivenOrder:
        """How the order stands."""
        code = self.process.poll()
        state: OrderState = "running" if code is None else "done" if code == 0 else "failed"
        return GivenOrder(
            action=self.action, subject=self.subject, person=self.person, at=self.at, state=state,
            fault=self._last_line() if state == "failed" else "",
        )  # fmt: skip

    def _last_line(self) -> str:
        lines = self.log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        return lines[-1][-LAST_LINE:] if lines else ""


class Orders:
    """The orders that were given since the pages are served."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._running: list[Running] = []

    def given(self) -> tuple[GivenOrder, ...]:
        """Every order that became a process, the last one first."""
        return tuple(each.given() for each in reversed(self._running))

    def give(self, action: Action, fields: Fields, visitor: Visitor) -> str:
        """Carries an order out, or begins to; gives what it is about.

        Raises Unusable where the role does not allow it, and for what cannot be carried out.
        """
        about = fields.get("certificate") or fields.get("run") or fields.get("station") or "*"
        check_may(action, visitor, about, self._home)
        given = {name: fields.get(name, "").strip() for name in FIELDS[action]}
        kept = {name: value for name, value in given.items() if value}
        for name in REQUIRED.get(action, ()):
            if name not in kept:
                label = message(f"pages-do-field.{name}")
                raise Unusable(f"{name} is empty", message("cause-empty", field=label))
        if action in STEPS:
            return self._step(action, kept, visitor.name)
        begin: dict[Action, Callable[[Fields, str], str]] = {
            "acquire": self._acquire, "reprocess": self._reprocess, "certify": self._certify,
            "amend": self._amend,
        }  # fmt: skip
        return begin[action](kept, visitor.name)

    def _step(self, action: Action, fields: Fields, person: str) -> str:
        """A step of a certificate, by the order and the function of its name."""
        kind, work = STEPS[action]
        why = "why" if "why" in kind.model_fields else "reason"
        given = {why if name == "reason" else name: value for name, value in fields.items()}
        order = order_of(kind, home=str(self._home.path), by=person, **given)
        return carry_out_signed(work, order).certificate.number

    def _certify(self, fields: Fields, person: str) -> str:
        """A run of the store, and no recording that lies elsewhere."""
        run = find(fields.get("run", ""), self._home).id
        options = [run, *self._limits(fields)]
        options += [f"--order={each}" for each in self._client_order(fields)]
        options += [f"--{name}={fields[name]}" for name in ("operator", "report") if name in fields]
        return self._begin("certify", run, person, options)

    def _amend(self, fields: Fields, person: str) -> str:
        """An issued certificate of the catalogue, with limits of the home."""
        number = certificates.entry_of(fields.get("certificate", ""), self._home).number
        options = [number, f"--why={fields.get('reason', '')}", *self._limits(fields)]
        return self._begin("amend", number, person, options)

    def _limits(self, fields: Fields) -> list[str]:
        """The option that names limits of the home."""
        known, folder = tolerance_files(self._home), self._home.tolerances
        return [f"--tolerance={each}" for each in _file_in(folder, known, fields.get("tolerance"))]

    def _client_order(self, fields: Fields) -> list[Path]:
        """The file of a client's order of the home; none without one."""
        known = production.client_orders_of(self._home)
        folder = production.client_order_folder(self._home)
        return _file_in(folder, known, fields.get("client_order"))

    def _acquire(self, fields: Fields, person: str) -> str:
        """An order for the queue of a station, by a procedure that comes with the program."""
        procedures.load(fields.get("procedure", "jjf2003"))
        named = {each: fields[each] for each in ("manufacturer", "model") if each in fields}
        serials = [each.strip() for each in fields.get("serial", "").split(",")]
        request = request_of(
            station=fields.get("station", ""),
            units=[named | {"serial": serial} for serial in serials],
            client_order=next((settings.read(f, Order) for f in self._client_order(fields)), None),
            **({"procedure": fields["procedure"]} if "procedure" in fields else {}),
        )
        given = production.give(request, person, self._home)
        return f"{given.order.serials} ({given.order.number})"

    def queue_step(
        self, step: str, number: str, visitor: Visitor, reason: str | None = None
    ) -> str:
        """Cancels an order of a queue, or has it carried out again; gives what it is about.

        Raises Unusable as `give` does.
        """
        check_may("acquire", visitor, number, self._home)
        if step == "cancel":
            return production.cancel(number, visitor.name, self._home).serials
        return production.retry(number, visitor.name, self._home, reason).order.serials

    def _reprocess(self, fields: Fields, person: str) -> str:
        order_of(ReprocessOrder, **fields)
        options = [f"--{name}={value}" for name, value in sorted(fields.items())]
        return self._begin("reprocess", " ".join(options) or "*", person, options)

    def _begin(self, action: Action, subject: str, person: str, options: list[str]) -> str:
        """Starts the command, with an entry in the trail."""
        now = datetime.now(UTC)
        log = self._home.path / "orders" / f"{now:%Y%m%dT%H%M%S.%f}-{action}.log"
        with database.changing(self._home) as connection:
            audit_trail.add(connection, person, f"order {action}", subject, at=now, log=log.name)
        with writing_in_home(log), log.open("wb") as output:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "flows.cli", action, "--json", *options],
                stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True,
                env=os.environ | {"MIMUCAL_HOME": str(self._home.path), "MIMUCAL_USER": person},
            )  # fmt: skip
        self._running.append(Running(action, subject, person, now, process, log))
        return subject


def _file_in(folder: Path, known: Sequence[str], name: str | None) -> list[Path]:
    """The file of a folder of the home that is named, as a list; empty where none is."""
    if name and name not in known:
        raise Unusable(
            f"there is no file {name!r} in {folder}", message("cause-none.file", name=name)
        )
    return [folder / name] if name else []


def check_may(action: Action, visitor: Visitor, subject: str, home: Home) -> None:
    """Raises NotAllowed, and logs it, for whom the role does not allow an action."""
    if not visitor.may(action):
        refused(home, action, subject, person=visitor.name or UNKNOWN, why=visitor.role)
        raise NotAllowed(
            f"{visitor.name or 'Nobody without a name'} ({visitor.role}) may not do this: "
            f"{action} is for {' and '.join(MAY[action])}",
            message("cause-may", action=message(f"pages-action.{action}"), roles=roles_of(action)),
        )


def roles_of(action: Action) -> tuple[Message, ...]:
    """The roles that allow an action."""
    return tuple(message(f"pages-role.{role}") for role in MAY[action])


def tolerance_files(home: Home) -> tuple[str, ...]:
    """The limits of the home, by the names of their files."""
    found = (path for path in home.tolerances.glob("*") if path.suffix in settings.READERS)
    return tuple(sorted(path.name for path in found))
