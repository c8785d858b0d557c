"""Puts together what the line is doing: stations, alarms, orders, flow runs and the day."""

import logging
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, date, datetime, timedelta
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

import sqlalchemy as sql
from pydantic import AwareDatetime, Field, ValidationError

from flows.on_prefect.server import server_named
from flows.orders import production
from flows.orders.production import LATE, failed_since, shown_cause
from flows.pages.do import check_may
from flows.pages.parts import today
from schemas.access import Visitor
from schemas.base import Frozen, NotThere, Unusable
from schemas.orders import OPEN, ProductionOrder
from schemas.recording import Alarm, RunStatus, State
from schemas.station import StationFile, StopRequest
from schemas.text import Statement
from storage import settings
from storage.catalogue import audit_trail, database, equipment, orders, tables
from storage.catalogue.database import Busy
from storage.catalogue.equipment import Reminder
from storage.catalogue.run_states import Condition, run_list
from storage.home import Home, environment
from storage.stations import (
    answer_in,
    file_of,
    folder_of,
    lockout_of,
    release,
    station_files,
    statuses,
)
from tasks.stages import prefect_api
from tasks.stages.stop import stop_station
from tasks.words import Sayable, cause_of, known, message, statement

# The stations at this moment, alarms, what waits, and today's output.

# Beside the states of a run. free: nothing runs there, as before the first run and after one that
# is done; lost: its process ended without a word; silent: nothing was heard of it for too long.
StationState = State | Literal["free", "lost", "silent"]
Waits = Literal["waiting", "running"]


class LineQuestion(Frozen):
    """All of the line."""


class AlarmShown(Frozen):
    """Something that a person must see to. station: empty where it is none of a station's; about:
    the unit, certificate or flow run; at: null where nobody knows when. key: identifies the alarm,
    as long as it stands. acknowledged: by whom and when; null while nobody did.
    """

    key: str

    at: AwareDatetime | None
    station: str
    about: str
    cause: Statement
    todo: Statement
    acknowledged: "Acknowledged | None" = None


class Acknowledged(Frozen):
    """A person saw to an alarm."""

    by: str
    at: AwareDatetime


class AlarmPressed(Frozen):
    """Whoever is logged in acknowledges an alarm, by its key."""

    alarm: str = Field(pattern="^[0-9a-f]{16}$")


class StopPressed(Frozen):
    """Whoever is logged in wants a station, by its id, to stop."""

    station: str = Field(min_length=1, max_length=200)


class Released(Frozen):
    """The orders of a station go on, as somebody wants who saw that it may turn."""

    station: str
    by: str


class StopShown(Frozen):
    """The last stop that was pressed for a station, and what became of it.

    is_at_rest: whether the table was read to stand still. fault: why that is not
    known; cause: the same as the page shows it.
    """

    by: str
    at: AwareDatetime
    is_at_rest: bool
    fault: str
    cause: Statement | None = None


class Queued(Frozen):
    """A production order that waits or runs. client: as the order names it. hindrance: what keeps
    one that waits from beginning.
    """

    number: str
    station: str
    serials: tuple[str, ...]
    procedure: str
    client: str
    state: Waits
    since: AwareDatetime
    hindrance: Statement | None = None


class StationNow(Frozen):
    """A station: its state, its last run (null before the first), and what waits for it.

    alarm: the last one of that run. lockout: the stop after which nobody has released it yet.
    """

    station: str
    state: StationState
    run: RunStatus | None
    alarm: AlarmShown | None
    stopped: StopShown | None
    lockout: StopRequest | None
    waiting: tuple[Queued, ...]


class Output(Frozen):
    """What a local day made: runs imported, by the verdict on them and on their units.

    not_judged: runs without a result. issued: certificates that were issued on that day.
    """

    day: date
    runs: int
    by_station: dict[str, int]
    valid: int
    remarks: int
    invalid: int
    not_judged: int
    passed: int
    failed: int
    issued: int


class FlowRun(Frozen):
    """A run on the Prefect server that is no production order, and what it is about."""

    flow: str
    deployment: str
    subject: str
    state: str
    is_late: bool
    expected_at: AwareDatetime | None
    pool: str


class Flows(Frozen):
    """The runs that the Prefect server holds, the next one of each deployment.

    server: whether one is named (PREFECT_API_URL). fault: why it did not answer.
    """

    server: bool
    fault: str | None = None
    runs: tuple[FlowRun, ...] = ()


class LineNow(Frozen):
    """What each station does, what is to be seen to, what waits, and what today made.

    orders: that wait for or run on any station, in their order. catalogue: why orders and today's
    output are not known (null); the stations are known all the same.
    """

    stations: tuple[StationNow, ...]
    alarms: tuple[AlarmShown, ...]
    orders: tuple[Queued, ...]
    flows: Flows
    today: Output | None
    catalogue: str | None = None


# What somebody must see to: its cause, and what to do about it.
#
# Of stations, of their files, of orders, of messages to clients and of Prefect's runs.

SHOWN = 20
ACKNOWLEDGE = "acknowledge alarm"
NO_SERVER = message("station-cause.no-server")
RECENT = timedelta(days=7)  # how long a failed order or a stopped run is shown


def newest(found: Iterable[AlarmShown]) -> tuple[AlarmShown, ...]:
    """The last ones first, those that somebody acknowledged at the end; what has no time stands
    now, and so before those that have.
    """
    latest = datetime.max.replace(tzinfo=UTC)
    last_first = sorted(found, key=lambda each: each.at or latest, reverse=True)
    return tuple(sorted(last_first, key=lambda each: each.acknowledged is not None)[:SHOWN])


def with_acknowledgement(found: Iterable[AlarmShown], home: Home) -> list[AlarmShown]:
    """The alarms, each with who acknowledged it last."""
    since = datetime.now(UTC) - RECENT
    known = {
        each.subject: Acknowledged(by=each.person, at=each.at)
        for each in audit_trail.of_action(ACKNOWLEDGE, since, home)
    }
    return [each.model_copy(update={"acknowledged": known.get(each.key)}) for each in found]


def of_station(now: StationNow) -> Iterator[AlarmShown]:
    """Why a station's last run stopped or is silent, and what was noticed in it."""
    run = now.run
    if run is None or datetime.now(UTC) - run.at > RECENT:
        return
    units = ", ".join(run.units)
    if now.state in ("stopped", "lost", "silent"):
        cause: Sayable = message(f"pages-line-cause.{now.state}")
        if run.cause:
            cause = run.shown_cause or cause_of(run.cause)
        todo = message(f"pages-line-todo.{now.state}", station=now.station)
        yield _alarm(run.at, now.station, units, cause, todo, (now.state, run.began_at))
    for each in run.alarms:
        known_by = (each.code or each.en, run.began_at)
        yield _alarm(each.at or run.at, now.station, units, each, _todo(each), known_by)


def _todo(alarm: Alarm) -> Sayable:
    """By the kind of the anomaly; a status of an earlier version names none."""
    id_ = f"station-todo.{alarm.code.replace('_', '-')}"
    return message(id_) if known(id_) else message("pages-line-todo.look")


def of_file(name: str, fault: str) -> AlarmShown:
    """A file in the home's stations that cannot be used."""
    return _alarm(None, "", name, cause_of(fault), message("pages-line-todo.file"))


def of_flows(flows: Flows) -> Iterator[AlarmShown]:
    """A server that does not answer, and runs whose time has passed."""
    if flows.fault is not None:
        yield _alarm(None, "", "Prefect", NO_SERVER, message("pages-line-todo.server"))
    for run in flows.runs:
        if run.is_late:
            yield _late(run)


def _late(run: FlowRun) -> AlarmShown:
    about = f"{run.deployment} {run.subject}".strip()
    todo = message("pages-line-todo.late", pool=run.pool or "default")
    return _alarm(run.expected_at, "", about, message("pages-line-cause.late"), todo)


def of_catalogue(home: Home) -> Iterator[AlarmShown]:
    """Orders that failed, and messages to clients that could not be sent."""
    now = datetime.now(UTC)
    for order in failed_since(now - RECENT, home):
        yield _of_order(order, order.ended_at or now, "order")
    for order in orders.waiting(home):
        if order.fault is not None and now - order.ordered_at > LATE:
            yield _of_order(order, order.ordered_at, "waits")
    for each in equipment.all_reminders(home):
        if each.sent_at is None and each.fault is not None:
            yield _unsent(each)


def _of_order(order: ProductionOrder, at: datetime, todo: str) -> AlarmShown:
    cause = message("pages-line-cause.order", number=order.number, fault=shown_cause(order))
    what = message(f"pages-line-todo.{todo}")
    return _alarm(at, order.station, order.serials, cause, what, (order.number, at))


def _unsent(reminder: Reminder) -> AlarmShown:
    """The time of the last attempt is not kept."""
    cause = message(
        "pages-line-cause.reminder", channel=reminder.channel, fault=cause_of(reminder.fault or "")
    )
    todo = message("pages-line-todo.reminder")
    return _alarm(None, "", reminder.certificate, cause, todo)


def _alarm(
    at: datetime | None, station: str, about: str, cause: Sayable, todo: Sayable,
    known_by: tuple[object, ...] = (),
) -> AlarmShown:  # fmt: skip
    """known_by: what distinguishes it from the next alarm about the same; else its cause."""
    cause = statement(cause)
    parts = (station, about, *(known_by or (cause.en,)))
    key = sha256("\n".join(map(str, parts)).encode()).hexdigest()[:16]
    return AlarmShown(
        key=key, at=at, station=station, about=about, cause=cause, todo=statement(todo)
    )


# What the Prefect server holds beside production orders, by deployment and subject.

NOW = ("PENDING", "RUNNING", "PAUSED", "CANCELLING")
LATE_STATE = "Late"  # Prefect's name of a scheduled run whose time has passed
PRODUCE = "produce"  # its runs are the orders of the catalogue
MOST = 200  # that the server gives at once
FRESH_S = 2.0  # shared by all visitors of the page
NAMED = ("run", "certificate", "serial", "model", "station", "recording", "since", "client")


def flow_runs() -> Flows:
    """What runs, what is late, and the next run of each deployment; none without a server."""
    if not server_named():
        return Flows(server=False)
    return _asked(str(environment().prefect_server), int(time.monotonic() / FRESH_S))


@lru_cache(maxsize=1)
def _asked(_: str, __: int) -> Flows:
    state = {"state": {"type": {"any_": ["SCHEDULED", *NOW]}}}
    asked = {"flow_runs": state, "sort": "EXPECTED_START_TIME_ASC", "limit": MOST}
    try:
        runs = prefect_api.post("/flow_runs/filter", asked)
        deployments, flows = (_names(kind, runs) for kind in ("deployment", "flow"))
        found = [_shown(run, deployments, flows) for run in runs]
        return Flows(server=True, runs=tuple(_next_of_each(found)))
    except prefect_api.NotAnswered as error:
        return Flows(server=True, fault=f"Prefect's server did not answer ({error})")
    except (ValueError, KeyError, TypeError) as error:
        why = type(error).__name__ if isinstance(error, ValidationError) else str(error)
        return Flows(server=True, fault=f"Prefect's server did not answer ({why})")


def _names(kind: str, runs: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The names of the deployments or flows of runs, by their ids."""
    ids = sorted({run[f"{kind}_id"] for run in runs if run.get(f"{kind}_id")})
    if not ids:
        return {}
    found = prefect_api.post(f"/{kind}s/filter", {f"{kind}s": {"id": {"any_": ids}}})
    return {each["id"]: each["name"] for each in found}


def _shown(
    run: Mapping[str, Any], deployments: Mapping[str, str], flows: Mapping[str, str]
) -> FlowRun:
    flow = flows.get(run["flow_id"], "")
    name = deployments.get(run.get("deployment_id") or "", flow)
    return FlowRun(
        flow=flow, deployment=name, subject=_subject(run.get("parameters") or {}),
        state=run["state_name"],
        is_late=run["state_name"] == LATE_STATE, expected_at=run["expected_start_time"],
        pool=run.get("work_pool_name") or "",
    )  # fmt: skip


def _subject(parameters: Mapping[str, Any]) -> str:
    """What a run is about: the fields of its order that name something."""
    order = parameters.get("order", parameters)
    if not isinstance(order, Mapping):
        return ""
    return ", ".join(str(order[name]) for name in NAMED if order.get(name))


def _next_of_each(runs: Sequence[FlowRun]) -> Iterator[FlowRun]:
    """Without production, whose queue the catalogue keeps, and without later runs of a schedule."""
    planned = set()
    for run in runs:
        if run.flow == PRODUCE:
            continue
        is_planned = run.state == "Scheduled"
        if is_planned and (run.flow, run.deployment) in planned:
            continue
        if is_planned:
            planned.add((run.flow, run.deployment))
        yield run


# Stops a station in the name of whoever pressed, and keeps what became of it.

LOG = logging.getLogger("mimucal.pages.stop")

_pressed: dict[tuple[Home, str], StopShown] = {}  # by station, since the pages are served


def last_stop(station: str, home: Home) -> StopShown | None:
    """The last stop of a station: pressed here since the pages are served, or else the one that
    keeps its orders waiting, if its run answered where the table was.
    """
    lockout, pressed = lockout_of(station, home), _pressed.get((home, station))
    if lockout is None or (pressed and pressed.at > lockout.at):
        return pressed
    answer = answer_in(home.locks, lockout)
    if answer and answer.at_rest is not None:
        return StopShown(by=lockout.by, at=lockout.at, is_at_rest=answer.at_rest, fault="")
    return pressed


def press(asked: StopPressed, visitor: Visitor, home: Home) -> StopShown:
    """Stops the station; whatever fails is said in the answer, and never raised.

    Raises NotAllowed where the role does not allow it, NotThere for an unknown station.
    """
    station = asked.station
    check_may("stop", visitor, station, home)
    if Path(station).is_file():  # which at a terminal is a station file
        raise NotThere(f"there is no station {station!r}; press Stop on its card")
    is_at_rest, cause = False, None
    try:
        stopped = stop_station(station, visitor.name, home)
        is_at_rest, fault, cause = stopped.at_rest, stopped.fault, stopped.cause
    except NotThere:
        raise
    except Exception as error:  # the person must be informed that the table may still turn
        if not isinstance(error, Unusable):
            LOG.exception("station %s was not stopped", station)
        fault, cause = str(error) or type(error).__name__, cause_of(error)
    shown = StopShown(
        by=visitor.name, at=datetime.now(UTC), is_at_rest=is_at_rest, fault=fault, cause=cause
    )
    _pressed[home, station] = shown
    return shown


def let_go_on(asked: StopPressed, visitor: Visitor, home: Home) -> Released:
    """Lets the orders of a station go on that was stopped.

    Raises NotAllowed where the role does not allow it, NotThere for an unknown station, Unusable
    where it cannot be written.
    """
    check_may("stop", visitor, asked.station, home)
    if lockout_of(asked.station, home) is None:
        file_of(asked.station, home)
    release(asked.station, visitor.name, home)
    LOG.info("station %s released by %s", asked.station, visitor.name)
    return Released(station=asked.station, by=visitor.name)


MOST_IN_A_DAY = 10_000
# A run writes its status every second; a slow network or a busy computer may delay that by some
# seconds, and after a minute the table can no longer be assumed to turn as intended.
SILENT = timedelta(seconds=30)
WRITING: tuple[State, ...] = ("warming_up", "measuring", "repeating")


def line_now(_: LineQuestion, home: Home) -> LineNow:
    """Stations, alarms, orders, flow runs and today's output.

    Without the catalogue the stations are known all the same.
    """
    named, unusable = [], []
    for name in station_files(home):
        try:
            named.append(settings.read(folder_of(home) / name, StationFile).station.id)
        except Unusable as error:
            unusable.append(of_file(name, str(error)))
    flows = flow_runs()
    found, fault = [*unusable, *of_flows(flows)], None
    queued: tuple[Queued, ...] = ()
    made = None
    try:
        if production.requeue_orphans(home, here=True):
            production.submit(home)
        queued = tuple(map(_queued, orders.listed(home, states=OPEN)))
        made = output(today(), home)
        found += of_catalogue(home)
    except Busy as error:
        fault = str(error)
    stations = tuple(_station_now(home, named, queued))
    found += [each for station in stations for each in of_station(station)]
    with suppress(Busy):
        found = with_acknowledgement(found, home)
    by_key = {each.key: each for each in found}
    stations = tuple(
        each.model_copy(update={"alarm": each.alarm and by_key[each.alarm.key]})
        for each in stations
    )
    return LineNow(
        stations=stations, alarms=newest(found), orders=queued, flows=flows, today=made,
        catalogue=fault,
    )  # fmt: skip


def acknowledge(asked: AlarmPressed, visitor: Visitor, home: Home) -> Acknowledged:
    """Enters in the audit trail that a person saw to an alarm that stands.

    Raises NotAllowed where the role does not allow it, NotThere where the alarm is over.
    """
    check_may("stop", visitor, asked.alarm, home)
    standing = line_now(LineQuestion(), home).alarms
    alarm = next((each for each in standing if each.key == asked.alarm), None)
    if alarm is None:
        raise NotThere(f"there is no alarm {asked.alarm} any more; look at the page again")
    now = datetime.now(UTC)
    with database.changing(home) as connection:
        audit_trail.add(
            connection, visitor.name, ACKNOWLEDGE, alarm.key, at=now, station=alarm.station,
            about=alarm.about, cause=alarm.cause.en,
        )  # fmt: skip
    return Acknowledged(by=visitor.name, at=now)


def _station_now(home: Home, named: Sequence[str], queued: Sequence[Queued]) -> list[StationNow]:
    """Every station with a file, a status or an order, in the order of their ids."""
    now = datetime.now(UTC)
    last = {status.station: (status, is_dead) for status, is_dead in statuses(home)}
    ids = sorted({*named, *last, *(each.station for each in queued)})
    found = []
    for station in ids:
        run, is_dead = last.get(station, (None, False))
        bare = StationNow(
            station=station, state=_state(run, is_dead, now), run=run, alarm=None,
            stopped=last_stop(station, home), lockout=lockout_of(station, home),
            waiting=tuple(each for each in queued if each.station == station),
        )  # fmt: skip
        of_run = newest(of_station(bare))
        found.append(bare.model_copy(update={"alarm": next(iter(of_run), None)}))
    return found


def _state(run: RunStatus | None, is_dead: bool, now: datetime) -> StationState:
    if run is None or run.state == "done":
        return "free"
    if is_dead:
        return "lost"
    return "silent" if run.state in WRITING and now - run.at > SILENT else run.state


def _queued(order: ProductionOrder) -> Queued:
    client = order.client_order.client.name if order.client_order else ""
    return Queued(
        number=order.number, station=order.station,
        serials=tuple(unit.serial for unit in order.units), procedure=order.procedure,
        client=client, state="running" if order.state == "running" else "waiting",
        since=order.began_at if order.state == "running" and order.began_at else order.ordered_at,
        hindrance=statement(shown_cause(order)) if order.fault else None,
    )  # fmt: skip


def output(day: date, home: Home) -> Output:
    """What a local day made."""
    made = Condition(column="imported_at", kind="equals", value=day)
    total, runs = run_list([made], [], 0, MOST_IN_A_DAY, home)
    validity, verdicts = Counter(r.validity for r in runs), Counter(r.verdict for r in runs)
    paper = tables.certificates.c
    issued = sql.select(sql.func.count()).where(
        paper.issued_on == day, paper.state.in_(("issued", "amended", "withdrawn"))
    )
    counted = database.rows(home, issued)
    return Output(
        day=day, runs=total, by_station=dict(Counter(r.station or "" for r in runs)),
        valid=validity["valid"], remarks=validity["remarks"], invalid=validity["invalid"],
        not_judged=validity[None], passed=verdicts["pass"], failed=verdicts["fail"],
        issued=counted[0][0] if counted else 0,
    )  # fmt: skip
