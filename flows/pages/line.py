"""The Line page: what each station is doing, today's output, and the queue."""

import time
from collections import Counter
from datetime import UTC, date, datetime
from functools import lru_cache

import dash_mantine_components as dmc
import httpx
import sqlalchemy as sql
from dash.development.base_component import Component
from pydantic import ValidationError

from flows.pages.page import Page, View
from flows.pages.parts import facts, table
from flows.pages.states import Kind, StepState, badge
from flows.prefect_server import server_named
from schemas.pages.line import LineNow, LineQuestion, Output, Queue, Queued, StationNow
from schemas.pages.runs import Condition
from storage.catalogue import database, tables
from storage.catalogue.run_states import run_list
from storage.environment import environment
from storage.home import Home
from storage.station_lock import statuses
from tasks.stages import prefect_api
from tasks.words import message

WAITING = ("PENDING", "SCHEDULED", "RUNNING", "PAUSED")
MOST = 50
TIMEOUT_S = 2.0
FRESH_S = 2.0  # for all who look at the page
REFRESH_S = 2.0
MOST_IN_A_DAY = 10_000


def data(_: LineQuestion, home: Home) -> LineNow:
    """The last run of each station, the output of the present day, and Prefect's queue."""
    return LineNow(
        stations=tuple(
            StationNow(status=status, is_dead=is_dead) for status, is_dead in statuses(home)
        ),
        today=output(datetime.now(UTC).date(), home),
        queue=queue(),
    )


def output(day: date, home: Home) -> Output:
    """What a day made, in UTC."""
    made = Condition(column="taken_in_at", kind="equals", value=day)
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


def layout(line: LineNow, view: View, _: LineQuestion) -> Component:
    """A card for each station, then the day, then the queue."""
    none = dmc.Text(view.say(message("pages-line-no-station")))
    cards = [_card(each, view) for each in line.stations]
    stations = dmc.SimpleGrid(cards, cols={"base": 1, "sm": 2, "xl": 3}) if cards else none
    return dmc.Stack(
        [
            stations,
            dmc.Title(view.say(message("pages-line-today", day=str(line.today.day))), order=3),
            _today(line.today, view),
            dmc.Title(view.say(message("pages-line-queue")), order=3),
            _queue(line.queue, view),
        ]
    )


def _card(now: StationNow, view: View) -> Component:
    status = now.status
    share = 100 * status.station_s_done / status.station_s_total if status.station_s_total else 0
    rates = ", ".join(f"{name} {rate:.1f} Hz" for name, rate in status.rates_hz.items())
    units = {"gyro": "°/s", "accel": "m/s²"}
    noise = ", ".join(f"{n} {x:.2g} {units.get(n, '')}" for n, x in status.noise.items())
    left = message("pages-line-minutes", minutes=f"{status.wall_s_left / 60:.0f}")
    alarms = [dmc.Alert(view.say(each), color="red", p="xs") for each in status.alarms]
    fault = [dmc.Alert(status.cause, color="red", p="xs")] if status.cause else []
    return dmc.Card(
        [
            dmc.Group(
                [dmc.Text(status.station, fw="bold"), badge(_state(now), view)],
                justify="space-between",
            ),
            dmc.Progress(value=min(share, 100), my="xs"),
            facts(
                [
                    (message("pages-line-unit"), ", ".join(status.units)),
                    (message("pages-column-procedure"), status.procedure),
                    (message("pages-line-now"), status.now),
                    (message("pages-line-segment"), f"{status.segment} / {status.segments}"),
                    (message("pages-line-left"), view.say(left)),
                    (message("pages-line-rates"), rates),
                    (message("pages-line-noise"), noise),
                    (message("pages-line-at"), f"{status.at:%F %T} UTC"),
                ],
                view,
            ),
            *alarms,
            *fault,
        ],
        withBorder=True,
        padding="md",
    )


def _state(now: StationNow) -> StepState:
    """A station whose process is dead, or whose run stopped, is bad; alarms leave it open."""
    if now.is_dead:
        return StepState(message("pages-line-dead"), "bad")
    state = now.status.state
    kinds: dict[str, Kind] = {"stopped": "bad", "paused": "open", "turning_over": "open"}
    kind = kinds.get(state, "open" if now.status.alarms else "good")
    return StepState(message(f"pages-run-state.{state.replace('_', '-')}"), kind)


def _today(today: Output, view: View) -> Component:
    stations = ", ".join(f"{name} {count}" for name, count in today.by_station.items())
    counts = {
        "runs": today.runs, "valid": today.valid, "remarks": today.remarks,
        "invalid": today.invalid, "not-judged": today.not_judged, "passed": today.passed,
        "failed": today.failed, "issued": today.issued,
    }  # fmt: skip
    shown = [(message(f"pages-line-output.{name}"), str(n)) for name, n in counts.items()]
    return facts([*shown, (message("pages-line-output.by-station"), stations)], view)


def _queue(waiting: Queue, view: View) -> Component:
    if not waiting.server:
        return dmc.Text(view.say(message("pages-line-no-server")))
    if waiting.fault is not None:
        return dmc.Alert(waiting.fault, color="red")
    rows = [
        (each.name, each.state, f"{each.expected_at:%F %T}" if each.expected_at else None)
        for each in waiting.waiting
    ]
    names = ("name", "state", "expected")
    return table([message(f"pages-queue-column.{name}") for name in names], rows, view)


def queue() -> Queue:
    """The flow runs that wait or run, the next one first; none where no server is named."""
    if not server_named():
        return Queue(server=False)
    return _asked(str(environment().prefect_server), int(time.monotonic() / FRESH_S))


@lru_cache(maxsize=1)
def _asked(url: str, _: int) -> Queue:
    asked = {
        "flow_runs": {"state": {"type": {"any_": WAITING}}},
        "sort": "EXPECTED_START_TIME_ASC",
        "limit": MOST,
    }
    try:
        answer = httpx.post(
            f"{url.rstrip('/')}/flow_runs/filter",
            json=asked,
            headers=prefect_api.headers(),
            timeout=TIMEOUT_S,
        )
        answer.raise_for_status()
        waiting = tuple(
            Queued(
                name=run["name"], state=run["state_name"], expected_at=run["expected_start_time"]
            )
            for run in answer.json()
        )
    except (httpx.HTTPError, httpx.InvalidURL, ValueError, KeyError, TypeError) as error:
        why = "ValidationError" if isinstance(error, ValidationError) else str(error)
        return Queue(server=True, fault=f"Prefect's server did not answer ({why})")
    return Queue(server=True, waiting=waiting)


PAGE = Page("line", LineQuestion, LineNow, data, layout, refresh_s=REFRESH_S)
