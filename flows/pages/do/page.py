"""Lays the Do page out, and carries out what is pressed there."""

from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any

import dash_mantine_components as dmc
import sqlalchemy as sql
from dash import ALL, MATCH, Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.development.base_component import Component

from flows.access_log import LOGGER, plain
from flows.orders import production
from flows.orders.outcomes import shown_cause
from flows.pages.do.actions import (
    FIELDS,
    REQUIRED,
    DoQuestion,
    DoShown,
    GivenOrder,
    Orders,
    WaitingCertificate,
    roles_of,
    tolerance_files,
)
from flows.pages.parts import (
    Kind,
    View,
    asking,
    badge,
    decision_state,
    facts,
    heading,
    notice,
    second_of,
    stated,
    table,
    view_of_request,
)
from schemas.access import MAY, Action
from schemas.base import Unusable
from schemas.certificate import LIVE
from schemas.orders import ENDED, OPEN, ProductionOrder
from schemas.recording import ENDED as RUN_ENDED
from schemas.text import texts_of
from storage.catalogue import certificates, database, orders, tables
from storage.home import Home
from storage.stations import station_ids, statuses
from tasks.station import procedures
from tasks.words import Message, cause_of, message

REFRESH_MS = 3000
SHOWN = 500  # certificates to choose from, the last ones
STEP_OF: dict[Action, str] = {
    "check": "draft", "issue": "checked", "amend": "issued", "withdraw": "issued",
}  # fmt: skip
ENDED_SHOWN = 50  # production orders that ended, the last ones
KINDS: dict[str, Kind] = {
    "waiting": "none", "running": "open", "done": "good", "failed": "bad", "cancelled": "none",
}  # fmt: skip
STEPS = {"waiting": "cancel", "failed": "retry", "cancelled": "retry"}


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


def layout(shown: DoShown, view: View, question: DoQuestion) -> Component:
    """A form for each order that the role allows; the orders given here; who may give which."""
    allowed = [action for action in FIELDS if view.visitor.may(action)]
    forms = [_form(action, shown, question, view) for action in allowed]
    why = "pages-do-nothing" if view.visitor.name else "pages-do-nobody"
    nothing = dmc.Alert(view.text(why), color="gray")
    busy: dict[str, Any] = {"data-busy": view.text("pages-do-busy")}
    return dmc.Stack(
        [
            html.Div(html.Div(id="do-answer"), className="answer", **busy),
            dmc.SimpleGrid(forms, cols={"base": 1, "sm": 2, "xl": 3}) if forms else nothing,
            heading("pages-do-queue", view),
            dmc.Box(_production(shown, view), id="do-production"),
            heading("pages-do-orders", view),
            dmc.Box(_orders(shown.orders, view), id="do-orders"),
            dcc.Interval(id="do-again", interval=REFRESH_MS),
            heading("pages-do-roles", view),
            _roles(view),
        ]
    )


def _form(action: Action, shown: DoShown, question: DoQuestion, view: View) -> Component:
    """A certificate's card ends with what is said of the chosen one, and the button with it."""
    title = dmc.Title(view.text(f"pages-action.{action}"), order=4)
    fields = [_field(action, name, shown, question, view) for name in FIELDS[action]]
    of_paper = "certificate" in FIELDS[action]
    end = dmc.Box(id={"of": action, "shows": "chosen"}) if of_paper else _button(action, view)
    return dmc.Card([dmc.Stack([title, *fields, end], gap="xs")], withBorder=True, padding="md")


def _button(action: Action, view: View, **more: Any) -> Component:
    color = "red" if action == "withdraw" else "blue"
    return dmc.Button(
        view.text(f"pages-action.{action}"), id={"do": action}, color=color, fullWidth=True,
        className="primary", **more,
    )  # fmt: skip


def chosen(action: Action, number: str | None, view: View, home: Home) -> Component:
    """What a certificate says, with its PDF, beside the button of its next step; without one
    nothing can be pressed. Withdrawing is asked first.
    """
    if not number:
        return _button(action, view, disabled=True)
    try:
        paper = certificates.record_of(certificates.entry_of(number, home), home)
    except Unusable as error:
        return notice(view, "pages-not-answered", "red", error)
    unit, decision = paper.manifest.unit, paper.decision
    counted = Counter(limit.verdict for limit in decision.limits)
    limits = view.text(
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
        "pages-column-verdict": badge(decision_state(decision.verdict), view),
        "pages-items-column.limits": limits,
    }
    pdf = html.A(
        view.text("pages-do-pdf"), href=f"/certificate/{number}.pdf", target="_blank",
        className="button",
    )  # fmt: skip
    question = view.text("pages-do-withdraw", certificate=number)
    asked = asking(question, view) if action == "withdraw" else {}
    reasons = [dmc.Text(view.say(each), size="sm") for each in texts_of(decision, "reasons")]
    return dmc.Stack([facts(about, view, 2), *reasons, pdf, _button(action, view, **asked)], gap=8)


def _field(
    action: Action, name: str, shown: DoShown, question: DoQuestion, view: View
) -> Component:
    chosen: dict[str, list[str]] = {
        "procedure": list(shown.procedures),
        "certificate": _certificates(action, shown),
        "client_order": list(shown.client_orders),
        "tolerance": list(shown.tolerances),
    }
    if action == "acquire":
        chosen["station"] = list(shown.stations)
    id_ = {"of": action, "field": name}
    label = view.text(f"pages-do-field.{name.replace('_', '-')}")
    given, needed = getattr(question, name, None), name in REQUIRED.get(action, ())
    if name not in chosen:
        return dmc.TextInput(id=id_, label=label, value=given or "", withAsterisk=needed)
    first = given if given in chosen[name] else None
    return dmc.Select(id=id_, label=label, data=chosen[name], value=first, searchable=True,
                      withAsterisk=needed)  # fmt: skip


def _certificates(action: Any, shown: DoShown) -> list[str]:
    """Those whose next step it is."""
    return [c.number for c in shown.certificates if c.state == STEP_OF.get(action)]


def _orders(given: tuple[GivenOrder, ...], view: View) -> Component:
    rows = [
        (
            second_of(each.at),
            each.person,
            view.text(f"pages-action.{each.action}"),
            each.subject,
            _state(each.state, None, view),
            each.fault and view.say(cause_of(each.fault)),
        )
        for each in given
    ]  # fmt: skip
    return table(
        "pages-order-column",
        "at person action subject state fault",
        rows,
        view,
        none="pages-do-no-order",
    )


def _production(shown: DoShown, view: View) -> Component:
    """The queue by station, unit and procedure, with what can be done about each order."""
    rows = [
        (
            each.station,
            each.serials,
            each.procedure,
            _state(each.state, shown.progress.get(each.station), view),
            each.person,
            second_of(each.ordered_at),
            each.number,
            view.say(shown_cause(each)) if each.fault else ", ".join(each.certificates),
            _step(each, view),
        )
        for each in shown.production
    ]
    names = "station unit procedure state person at number outcome step"
    return table("pages-order-column", names, rows, view, none="pages-do-no-order")


def _state(state: str, share: float | None, view: View) -> Component:
    """Of an order that runs with how far it is, or else that it moves."""
    shown = badge(stated(f"pages-order.{state}", KINDS[state]), view)
    bar = dmc.Progress(value=100 * (share or 1.0), animated=share is None)
    return dmc.Stack([shown, *([bar] if state == "running" else [])], gap=4)


def _step(order: ProductionOrder, view: View) -> Component | None:
    step = STEPS.get(order.state)
    if step is None or not view.visitor.may("acquire"):
        return None
    id_ = {"step": step, "number": order.number}
    return dmc.Button(view.text(f"pages-order-step.{step}"), id=id_)


def _roles(view: View) -> Component:
    """Which role may do what, as it stands."""
    rows = [(view.text(f"pages-action.{action}"), view.text("pages-roles", roles=roles_of(action)))
            for action in MAY]  # fmt: skip
    return table("pages-roles-column", "action roles", rows, view)


def callbacks(app: Dash, home: Home) -> None:
    """A button gives its order, in the name of whoever is logged in."""

    @app.callback(
        Output("do-production", "children"),
        Output("do-orders", "children"),
        Output({"of": ALL, "field": "certificate"}, "data"),
        Input("do-again", "n_intervals"),
    )
    def refresh(_: int | None) -> tuple[Component, Component, list[list[str]]]:
        view, shown = view_of_request(), data(DoQuestion(), home)
        listed = [_certificates(each["id"].get("of"), shown) for each in ctx.outputs_list[2]]
        return _production(shown, view), _orders(shown.orders, view), listed

    @app.callback(
        Output({"of": MATCH, "shows": "chosen"}, "children"),
        Input({"of": MATCH, "field": "certificate"}, "value"),
    )
    def choose(number: str | None) -> Any:
        action = next((each for each in STEP_OF if each == ctx.outputs_list["id"]["of"]), None)
        if action is None or not isinstance(number, str | None):
            return no_update
        return chosen(action, number, view_of_request(), home)

    @app.callback(
        Output("do-answer", "children", allow_duplicate=True),
        Input({"step": ALL, "number": ALL}, "n_clicks"),
        prevent_initial_call=True,
    )
    def take_step(clicks: list[int | None]) -> Any:
        if not any(clicks) or not isinstance(ctx.triggered_id, dict):
            return no_update
        return step_answer(ctx.triggered_id, view_of_request(), home)

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
        view, action = view_of_request(), ctx.triggered_id["do"]
        fields = {
            each["field"]: value or ""
            for each, value in zip(ids, values, strict=True)
            if each["of"] == action
        }
        return answer(action, fields, view, home)


def answer(action: str, fields: dict[str, str], view: View, home: Home) -> Component:
    """Gives an order; what became of it, as a sentence."""
    known = next((each for each in FIELDS if each == action), None)
    if known is None or not all(isinstance(value, str) for value in fields.values()):
        LOGGER.warning("order %s refused to %s: no such order", plain(action), view.visitor.name)
        return dmc.Alert(view.text("pages-not-answered"), color="red")
    words = message(f"pages-action.{action}")
    return _became(words, view, lambda: orders_of(home).give(known, fields, view.visitor))


def step_answer(button: dict[str, str], view: View, home: Home) -> Component:
    """Cancels an order of a queue or repeats it; what became of it, as a sentence."""
    step, number = button["step"], button["number"]
    words = message(f"pages-order-step.{step}")
    return _became(words, view, lambda: orders_of(home).queue_step(step, number, view.visitor))


def _became(action: Message, view: View, give: Callable[[], str]) -> Component:
    try:
        return dmc.Alert(view.text("pages-do-done", action=action, subject=give()), color="green")
    except Unusable as error:
        return notice(view, "pages-do-refused", "red", error)
