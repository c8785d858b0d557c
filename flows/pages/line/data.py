"""Puts together what the line is doing: stations, alarms, orders, flow runs and the day."""

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, date, datetime, timedelta

import sqlalchemy as sql

from flows.orders import order_queue
from flows.orders.outcomes import shown_cause
from flows.pages.do.orders import check_may
from flows.pages.line import alarms
from flows.pages.line.flow_runs import flow_runs
from flows.pages.line.models import (
    Acknowledged,
    AlarmPressed,
    LineNow,
    LineQuestion,
    Output,
    Queued,
    StationNow,
    StationState,
)
from flows.pages.line.stops import last_stop
from flows.pages.local_time import today
from schemas.access import Visitor
from schemas.base import NotThere, Unusable
from schemas.production import OPEN, ProductionOrder
from schemas.run_log import RunStatus, State
from schemas.station import StationFile
from storage import settings
from storage.catalogue import database, orders, tables, trail
from storage.catalogue.connection import Busy
from storage.catalogue.run_states import Condition, run_list
from storage.home import Home
from storage.station_lock import statuses
from storage.station_stop import lockout_of
from storage.stations import folder_of, station_files
from tasks.words import statement

MOST_IN_A_DAY = 10_000
# A run writes its status every second; a slow network or a busy computer may delay that by some
# seconds, and after a minute the table can no longer be assumed to turn as intended.
SILENT = timedelta(seconds=30)
WRITING: tuple[State, ...] = ("warming_up", "measuring", "repeating")


def data(_: LineQuestion, home: Home) -> LineNow:
    """Stations, alarms, orders, flow runs and today's output.

    Without the catalogue the stations are known all the same.
    """
    named, unusable = [], []
    for name in station_files(home):
        try:
            named.append(settings.read(folder_of(home) / name, StationFile).station.id)
        except Unusable as error:
            unusable.append(alarms.of_file(name, str(error)))
    flows = flow_runs()
    found, fault = [*unusable, *alarms.of_flows(flows)], None
    queued: tuple[Queued, ...] = ()
    made = None
    try:
        if order_queue.take_up_left(home, here=True):
            order_queue.submit(home)
        queued = tuple(map(_queued, orders.listed(home, states=OPEN)))
        made = output(today(), home)
        found += alarms.of_catalogue(home)
    except Busy as error:
        fault = str(error)
    stations = tuple(_station_now(home, named, queued))
    found += [each for station in stations for each in alarms.of_station(station)]
    with suppress(Busy):
        found = alarms.with_acknowledgement(found, home)
    by_key = {each.key: each for each in found}
    stations = tuple(
        each.model_copy(update={"alarm": each.alarm and by_key[each.alarm.key]})
        for each in stations
    )
    return LineNow(
        stations=stations, alarms=alarms.newest(found), orders=queued, flows=flows, today=made,
        catalogue=fault,
    )  # fmt: skip


def acknowledge(asked: AlarmPressed, visitor: Visitor, home: Home) -> Acknowledged:
    """Enters in the audit trail that a person saw to an alarm that stands.

    Raises NotAllowed where the role does not allow it, NotThere where the alarm is over.
    """
    check_may("stop", visitor, asked.alarm, home)
    standing = data(LineQuestion(), home).alarms
    alarm = next((each for each in standing if each.key == asked.alarm), None)
    if alarm is None:
        raise NotThere(f"there is no alarm {asked.alarm} any more; look at the page again")
    now = datetime.now(UTC)
    with database.changing(home) as connection:
        trail.add(
            connection, visitor.name, alarms.ACKNOWLEDGE, alarm.key, at=now, station=alarm.station,
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
        of_run = alarms.newest(alarms.of_station(bare))
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
