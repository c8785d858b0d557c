"""The Do page: start a run, re-process, draft, check, issue and withdraw, as the role allows."""

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, Literal

import dash_mantine_components as dmc
import sqlalchemy as sql
from dash import ALL, MATCH, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component
from pydantic import AwareDatetime

from flows import execute
from flows.access_log import LOGGER, UNKNOWN, plain, refused
from flows.orders import production
from flows.orders.order_files import request_of
from flows.orders.production import shown_cause
from flows.orders.signed_orders import carry_out_signed
from flows.pages.parts import (
    Kind,
    Page,
    asking,
    badge,
    decision_state,
    facts,
    heading,
    notice,
    said,
    say,
    second_of,
    stated,
    table,
    view,
)
from schemas.access import MAY, Action, Visitor
from schemas.base import Finite, Frozen, NotAllowed, Unusable
from schemas.certificate import LIVE, Order
from schemas.certificate import State as CertificateState
from schemas.orders import (
    ENDED,
    OPEN,
    CheckOrder,
    IssueOrder,
    ProductionOrder,
    ReprocessOrder,
    WithdrawOrder,
    order_of,
)
from schemas.recording import ENDED as RUN_ENDED
from schemas.text import texts_of
from storage import settings
from storage.catalogue import audit_trail, certificates, database, orders, tables
from storage.catalogue.runs import find
from storage.home import Home
from storage.stations import station_ids, statuses
from storage.whole_files import writing_in_home
from tasks.station import procedures
from tasks.words import Message, cause_of, message

# What can be ordered from the pages, and what became of it.

OrderState = Literal["running", "done", "failed"]


class DoQuestion(Frozen):
    """A run or a certificate that the forms begin with."""

    run: str | None = None
    certificate: str | None = None


class WaitingCertificate(Frozen):
    """A certificate whose next step is to be taken, or that may be withdrawn."""

    number: str
    state: CertificateState
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
    "check": (CheckOrder, execute.check),
    "issue": (IssueOrder, execute.issue),
    "withdraw": (WithdrawOrder, execute.withdraw),
}
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


# Lays the Do page out, and carries out what is pressed there.


REFRESH_MS = 3000
SHOWN = 500  # certificates to choose from, the last ones
STEP_OF: dict[Action, str] = {
    "check": "draft", "issue": "checked", "amend": "issued", "withdraw": "issued",
}  # fmt: skip
ENDED_SHOWN = 50  # production orders that ended, the last ones
KINDS: dict[str, Kind] = {
    "waiting": "none", "running": "open", "done": "good", "failed": "bad", "cancelled": "none",
}  # fmt: skip
QUEUE_STEPS = {"waiting": "cancel", "failed": "retry", "cancelled": "retry"}


@cache
def orders_of(home: Home) -> Orders:
    """The orders given to a home in this process."""
    return Orders(home)


def data(_: DoQuestion, home: Home) -> DoShown:
    """What there is to choose from, and the orders given here."""
    paper, unit = tables.certificates.c, tables.units.c
    named = (paper.number, paper.state, unit.manufacturer, unit.model, unit.serial)
    asked = sql.select(*named).join_from(tables.certificates, tables.units)
    newest = asked.where(paper.state.in_(LIVE)).order_by(paper.kept_at.desc()).limit(SHOWN)
    return DoShown(
        stations=station_ids(home),
        procedures=procedures.names(),
        client_orders=production.client_orders_of(home),
        tolerances=tolerance_files(home),
        production=(
            *orders.listed(home, states=ENDED, last=ENDED_SHOWN),
            *orders.listed(home, states=OPEN),
        ),
        progress={
            status.station: status.station_s_done / status.station_s_total
            for status, is_dead in statuses(home)
            if not is_dead and status.state not in RUN_ENDED and status.station_s_total
        },
        certificates=tuple(
            WaitingCertificate(
                number=row.number,
                state=row.state,
                unit=f"{row.manufacturer} {row.model} {row.serial}",
            )
            for row in database.rows(home, newest)
        ),
        orders=orders_of(home).given(),
    )


def layout(shown: DoShown, question: DoQuestion) -> Component:
    """A form for each order that the role allows; the orders given here; who may give which."""
    allowed = [action for action in FIELDS if view().visitor.may(action)]
    forms = [_form(action, shown, question) for action in allowed]
    why = "pages-do-nothing" if view().visitor.name else "pages-do-nobody"
    nothing = dmc.Alert(said(why), color="gray")
    busy: dict[str, Any] = {"data-busy": said("pages-do-busy")}
    return dmc.Stack(
        [
            html.Div(html.Div(id="do-answer"), className="answer", **busy),
            dmc.SimpleGrid(forms, cols={"base": 1, "sm": 2, "xl": 3}) if forms else nothing,
            heading("pages-do-queue"),
            dmc.Box(_production(shown), id="do-production"),
            heading("pages-do-orders"),
            dmc.Box(_orders(shown.orders), id="do-orders"),
            dcc.Interval(id="do-again", interval=REFRESH_MS),
            heading("pages-do-roles"),
            _roles(),
        ]
    )


def _form(action: Action, shown: DoShown, question: DoQuestion) -> Component:
    """A certificate's card ends with what is said of the chosen one, and the button with it."""
    title = dmc.Title(said(f"pages-action.{action}"), order=4)
    fields = [_field(action, name, shown, question) for name in FIELDS[action]]
    of_paper = "certificate" in FIELDS[action]
    end = dmc.Box(id={"of": action, "shows": "chosen"}) if of_paper else _button(action)
    return dmc.Card([dmc.Stack([title, *fields, end], gap="xs")], withBorder=True, padding="md")


def _button(action: Action, **more: Any) -> Component:
    color = "red" if action == "withdraw" else "blue"
    return dmc.Button(
        said(f"pages-action.{action}"), id={"do": action}, color=color, fullWidth=True,
        className="primary", **more,
    )  # fmt: skip


def chosen(action: Action, number: str | None, home: Home) -> Component:
    """What a certificate says, with its PDF, beside the button of its next step; without one
    nothing can be pressed. Withdrawing is asked first.
    """
    if not number:
        return _button(action, disabled=True)
    try:
        paper = certificates.record_of(certificates.entry_of(number, home), home)
    except Unusable as error:
        return notice("pages-not-answered", "red", error)
    unit, decision = paper.manifest.unit, paper.decision
    counted = Counter(limit.verdict for limit in decision.limits)
    limits = said(
        "pages-do-limits", passed=counted["pass"], failed=counted["fail"],
        open=counted["inconclusive"],
    )  # fmt: skip
    about = {
        "pages-order-column.unit": f"{unit.manufacturer} {unit.model} {unit.serial}",
        "pages-line-order.client": paper.order.client.name if paper.order else None,
        "pages-certificate-column.calibrated": str(paper.calibrated_on or "–"),
        **{
            f"pages-do-step.{step.step}": f"{step.person}, {second_of(step.at)}"
            for step in paper.steps
        },
        "pages-column-verdict": badge(decision_state(decision.verdict)),
        "pages-items-column.limits": limits,
    }
    pdf = html.A(
        said("pages-do-pdf"), href=f"/certificate/{number}.pdf", target="_blank", className="button"
    )
    question = said("pages-do-withdraw", certificate=number)
    asked = asking(question) if action == "withdraw" else {}
    reasons = [dmc.Text(say(each), size="sm") for each in texts_of(decision, "reasons")]
    return dmc.Stack([facts(about, 2), *reasons, pdf, _button(action, **asked)], gap=8)


def _field(action: Action, name: str, shown: DoShown, question: DoQuestion) -> Component:
    chosen: dict[str, list[str]] = {
        "procedure": list(shown.procedures),
        "certificate": _certificates(action, shown),
        "client_order": list(shown.client_orders),
        "tolerance": list(shown.tolerances),
    }
    if action == "acquire":
        chosen["station"] = list(shown.stations)
    id_ = {"of": action, "field": name}
    label = said(f"pages-do-field.{name.replace('_', '-')}")
    given, needed = getattr(question, name, None), name in REQUIRED.get(action, ())
    if name not in chosen:
        return dmc.TextInput(id=id_, label=label, value=given or "", withAsterisk=needed)
    first = given if given in chosen[name] else None
    return dmc.Select(
        id=id_, label=label, data=chosen[name], value=first, searchable=True, withAsterisk=needed
    )


def _certificates(action: Any, shown: DoShown) -> list[str]:
    """Those whose next step it is."""
    return [c.number for c in shown.certificates if c.state == STEP_OF.get(action)]


def _orders(given: tuple[GivenOrder, ...]) -> Component:
    rows = [
        (
            second_of(each.at),
            each.person,
            said(f"pages-action.{each.action}"),
            each.subject,
            _state(each.state, None),
            each.fault and say(cause_of(each.fault)),
        )
        for each in given
    ]
    return table(
        "pages-order-column",
        "at person action subject state fault",
        rows,
        none="pages-do-no-order",
    )


def _production(shown: DoShown) -> Component:
    """The queue by station, unit and procedure, with what can be done about each order."""
    rows = [
        (
            each.station,
            each.serials,
            each.procedure,
            _state(each.state, shown.progress.get(each.station)),
            each.person,
            second_of(each.ordered_at),
            each.number,
            say(shown_cause(each)) if each.fault else ", ".join(each.certificates),
            _step(each),
        )
        for each in shown.production
    ]
    names = "station unit procedure state person at number outcome step"
    return table("pages-order-column", names, rows, none="pages-do-no-order")


def _state(state: str, share: float | None) -> Component:
    """Of an order that runs with how far it is, or else that it moves."""
    shown = badge(stated(f"pages-order.{state}", KINDS[state]))
    bar = dmc.Progress(value=100 * (share or 1.0), animated=share is None)
    return dmc.Stack([shown, *([bar] if state == "running" else [])], gap=4)


def _step(order: ProductionOrder) -> Component | None:
    step = QUEUE_STEPS.get(order.state)
    if step is None or not view().visitor.may("acquire"):
        return None
    id_ = {"step": step, "number": order.number}
    return dmc.Button(said(f"pages-order-step.{step}"), id=id_)


def _roles() -> Component:
    """Which role may do what, as it stands."""
    rows = [(said(f"pages-action.{action}"), said("pages-roles", roles=roles_of(action)))
            for action in MAY]  # fmt: skip
    return table("pages-roles-column", "action roles", rows)


def callbacks(app: Dash, home: Home) -> None:
    """A button gives its order, in the name of whoever is logged in."""

    @app.callback(
        Output("do-production", "children"),
        Output("do-orders", "children"),
        Output({"of": ALL, "field": "certificate"}, "data"),
        Input("do-again", "n_intervals"),
    )
    def refresh(_: int | None) -> tuple[Component, Component, list[list[str]]]:
        shown = data(DoQuestion(), home)
        listed = [_certificates(each["id"].get("of"), shown) for each in ctx.outputs_list[2]]
        return _production(shown), _orders(shown.orders), listed

    @app.callback(
        Output({"of": MATCH, "shows": "chosen"}, "children"),
        Input({"of": MATCH, "field": "certificate"}, "value"),
    )
    def choose(number: str | None) -> Any:
        action = next((each for each in STEP_OF if each == ctx.outputs_list["id"]["of"]), None)
        if action is None or not isinstance(number, str | None):
            return no_update
        return chosen(action, number, home)

    @app.callback(
        Output("do-answer", "children", allow_duplicate=True),
        Input({"step": ALL, "number": ALL}, "n_clicks"),
        prevent_initial_call=True,
    )
    def take_step(clicks: list[int | None]) -> Any:
        if not any(clicks) or not isinstance(ctx.triggered_id, dict):
            return no_update
        return step_answer(ctx.triggered_id, home)

    @app.callback(
        Output("do-answer", "children"),
        Input({"do": ALL}, "n_clicks"),
        State({"of": ALL, "field": ALL}, "value"),
        State({"of": ALL, "field": ALL}, "id"),
        running=[(Output("do-answer", "className"), "is-busy", "")],
        prevent_initial_call=True,
    )
    def give(clicks: list[int | None], values: list[str | None], ids: list[dict[str, str]]) -> Any:
        if not any(clicks) or not isinstance(ctx.triggered_id, dict):
            return no_update
        action = ctx.triggered_id["do"]
        fields = {
            each["field"]: value or ""
            for each, value in zip(ids, values, strict=True)
            if each["of"] == action
        }
        return answer(action, fields, home)


def answer(action: str, fields: dict[str, str], home: Home) -> Component:
    """Gives an order; what became of it, as a sentence."""
    known = next((each for each in FIELDS if each == action), None)
    if known is None or not all(isinstance(value, str) for value in fields.values()):
        LOGGER.warning("order %s refused to %s: no such order", plain(action), view().visitor.name)
        return dmc.Alert(said("pages-not-answered"), color="red")
    words = message(f"pages-action.{action}")
    return _became(words, lambda: orders_of(home).give(known, fields, view().visitor))


def step_answer(button: dict[str, str], home: Home) -> Component:
    """Cancels an order of a queue or repeats it; what became of it, as a sentence."""
    step, number = button["step"], button["number"]
    words = message(f"pages-order-step.{step}")
    return _became(words, lambda: orders_of(home).queue_step(step, number, view().visitor))


def _became(action: Message, give: Callable[[], str]) -> Component:
    try:
        return dmc.Alert(said("pages-do-done", action=action, subject=give()), color="green")
    except Unusable as error:
        return notice("pages-do-refused", "red", error)


PAGE = Page("do", DoQuestion, DoShown, data, layout, callbacks=callbacks)
