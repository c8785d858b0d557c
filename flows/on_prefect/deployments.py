"""The deployments of a line on the Prefect server that PREFECT_API_URL names.

Each names a flow by its module: a worker needs mimucal installed, and no folder. Every station has
a work pool of its own that carries out one run at a time; the limit of a pool counts the runs in
the server's database, and so outlives the server. Import this module only after
`flows.on_prefect.server.connect`.
"""

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import timedelta
from typing import Any
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient
from prefect.client.schemas.actions import (
    DeploymentScheduleCreate,
    WorkPoolCreate,
    WorkPoolUpdate,
)
from prefect.client.schemas.objects import StateType
from prefect.client.schemas.schedules import CronSchedule
from prefect.events.actions import ChangeFlowRunState, RunDeployment
from prefect.events.schemas.automations import AutomationCore, EventTrigger, Posture
from prefect.exceptions import ObjectAlreadyExists, ObjectNotFound
from prefect.utilities.callables import parameter_schema
from prefect.workers.process import ProcessWorker

from flows.on_prefect import flows
from flows.on_prefect.queue import LINE, PATIENT, pool_of
from flows.on_prefect.server import prefect_client
from schemas.base import Unusable, has_secret
from storage.home import Home

# What Prefect monitors: runs that are late, crashed or without heartbeat, and workers.

WATCHED = ("produce", "certify", "reprocess", "remind", "review")  # the flow `alert` never
# An order is late by design: it waits for its station. Its pool reports if no worker takes it.
SCHEDULED_FLOWS = tuple(flow for flow in WATCHED if flow != "produce")
NO_HEARTBEAT = timedelta(seconds=120)  # three heartbeats of a run are missing
ENDS = ("Completed", "Failed", "Crashed", "Cancelled")
RUN = "prefect.flow-run"
OF_A_RUN = "Run {{ flow_run.name }} of {{ flow.name }}"


def automate(client: SyncPrefectClient, alert: UUID) -> None:
    """Creates or updates the automations. alert: the deployment that sends a sentence."""
    for automation in automations(alert):
        known = client.read_automations_by_name(automation.name)
        if known:
            client.update_automation(known[0].id, automation)
        else:
            client.create_automation(automation)


def automations(alert: UUID) -> list[AutomationCore]:
    """A run that is late, crashed or silent; a pool without a worker; what a run says itself."""
    late = f"{OF_A_RUN} is late: see that the worker of its pool lives."
    crashed = f"{OF_A_RUN} crashed or is silent: see its log in Prefect, its station and computer."
    pool = "Work pool {{ work_pool.name }} has no live worker: start it on its computer."
    invalid = (
        "Unit {{ event.resource.name }} on station {{ event.payload.station }}: an invalid run: "
        "{{ event.payload.why }} Remove the cause, then repeat the order."
    )
    reminder = "Unit {{ event.resource.name }}: a reminder not sent: {{ event.payload.why }}"
    died = ChangeFlowRunState(
        state=StateType.CRASHED, name="Crashed", message="no heartbeat", force=False
    )
    return [
        _on("a run is late", _of_runs([f"{RUN}.Late"], SCHEDULED_FLOWS), _alerted(alert, late)),
        _on("a run crashed", _of_runs([f"{RUN}.Crashed"], WATCHED), _alerted(alert, crashed)),
        # It alerts as one that crashed; one that had ended meanwhile keeps its state.
        _on("a run is silent", _silent(), died),
        _on("a pool has no worker", _of_pools(), _alerted(alert, pool)),
        _on("a run is invalid", _of_units("run.invalid"), _alerted(alert, invalid)),
        _on("a reminder failed", _of_units("reminder.failed"), _alerted(alert, reminder)),
    ]


def _on(name: str, trigger: EventTrigger, *actions: Any) -> AutomationCore:
    return AutomationCore(name=f"mimucal: {name}", trigger=trigger, actions=list(actions))


def _alerted(alert: UUID, sentence: str) -> RunDeployment:
    order = {"sentence": {"__prefect_kind": "jinja", "template": sentence}}
    return RunDeployment(
        source="selected", deployment_id=alert, parameters={"order": order}, job_variables=None
    )


def _of_runs(events: Iterable[str], flows: Iterable[str]) -> EventTrigger:
    return EventTrigger(
        expect=set(events),
        match={"prefect.resource.id": f"{RUN}.*"},
        match_related={"prefect.resource.role": "flow", "prefect.resource.name": list(flows)},
        posture=Posture.Reactive,
        threshold=1,
    )


def _silent() -> EventTrigger:
    """A run that sent a heartbeat and then neither sends another nor ends."""
    beat = f"{RUN}.heartbeat"
    return EventTrigger(
        after={beat},
        expect={beat} | {f"{RUN}.{end}" for end in ENDS},
        for_each={"prefect.resource.id"},
        match={"prefect.resource.id": f"{RUN}.*"},
        posture=Posture.Proactive,
        threshold=1,
        within=NO_HEARTBEAT,
    )


def _of_pools() -> EventTrigger:
    return EventTrigger(
        expect={"prefect.work-pool.not-ready"},
        match={"prefect.resource.id": "prefect.work-pool.*"},
        posture=Posture.Reactive,
        threshold=1,
    )


def _of_units(event: str) -> EventTrigger:
    return EventTrigger(
        expect={f"mimucal.{event}"},
        match={"prefect.resource.id": "mimucal.unit.*"},
        posture=Posture.Reactive,
        threshold=1,
    )


AGAIN = "then repeat the command"
PASSED_ON = ("MIMUCAL_DATABASE", "MIMUCAL_STORE", "MIMUCAL_STATION")


@dataclass(frozen=True)
class Deployed:
    """A deployment. flow: its name in `flows.on_prefect.flows`. alone: one run at a time.

    cron: when it runs by itself; null where somebody orders it.
    """

    flow: str
    description: str
    name: str = ""
    pool: str = LINE
    order: Mapping[str, Any] = field(default_factory=dict)
    alone: bool = False
    cron: str | None = None


OF_THE_LINE = (
    Deployed("certify", "The result of a run that is there, and the draft of its certificate."),
    Deployed("check", "A person checked the draft of a certificate."),
    Deployed("issue", "A checked certificate gets its number, and is never changed again."),
    Deployed("amend", "The draft of a certificate in the place of an issued one."),
    Deployed("withdraw", "An issued certificate is withdrawn."),
    Deployed("reprocess", "The results of past runs, made again with today's code.", alone=True),
    Deployed(
        "remind", "Reminders of recalibration; what could not be sent is tried again later.",
        order={"within_days": 30}, alone=True, cron="*/10 * * * *",
    ),
    Deployed(
        "submit", "Orders that wait are given to Prefect again, where it lost them.",
        alone=True, cron="* * * * *",
    ),
    Deployed(
        "review", "What all runs show together, who carries it, and which certificates it touched.",
        alone=True, cron="0 3 1 * *",
    ),
    Deployed("alert", "A sentence to whoever operates the line."),
)  # fmt: skip


def deploy_line(home: Home, timezone: str) -> tuple[str, ...]:
    """Creates or updates everything that needs no station; gives the names of the deployments."""
    with prefect_client(AGAIN) as client:
        _pool(client, LINE, None)
        made = {each.flow: _deployment(client, each, home, timezone) for each in OF_THE_LINE}
        automate(client, made["alert"])
    return tuple(f"{each.flow}/{each.name or each.flow}" for each in OF_THE_LINE)


def deploy_station(station: str, file: str, home: Home, cron: str | None, timezone: str) -> str:
    """Creates or updates the pool and the deployment of a station; gives the pool's name.

    file: its station file in the home.
    """
    pool = pool_of(station)
    produce = Deployed(
        "produce", f"A unit on station {station}, from power-on to the draft of its certificate.",
        name=station, pool=pool, order={"station": file}, cron=cron,
    )  # fmt: skip
    with prefect_client(AGAIN) as client:
        _pool(client, pool, 1)
        _deployment(client, produce, home, timezone)
    return pool


def remove_station(station: str) -> None:
    """Removes what `deploy_station` made, where it is there."""
    with prefect_client(AGAIN) as client:
        with suppress(ObjectNotFound):
            deployment = client.read_deployment_by_name(f"produce/{station}")
            client.delete_deployment(deployment.id)
        with suppress(ObjectNotFound):
            client.delete_work_pool(pool_of(station))


def _pool(client: SyncPrefectClient, name: str, limit: int | None) -> None:
    template = ProcessWorker.get_default_base_job_template()
    pool = WorkPoolCreate(
        name=name, type="process", base_job_template=template, concurrency_limit=limit
    )
    try:
        client.create_work_pool(pool)
    except ObjectAlreadyExists:
        client.update_work_pool(name, WorkPoolUpdate(concurrency_limit=limit))


def _deployment(client: SyncPrefectClient, each: Deployed, home: Home, timezone: str) -> UUID:
    """A deployment in the place of one with its name: also its schedules are those given here."""
    named: Any = getattr(flows, each.flow)
    schedules = []
    if each.cron:
        try:
            cron = CronSchedule(cron=each.cron, timezone=timezone)
        except ValueError as error:
            raise Unusable(
                f"--schedule {each.cron!r} in time zone {timezone!r} is none: give five fields, as "
                "'0 8 * * 1-5', and a time zone like Asia/Shanghai"
            ) from error
        schedules = [DeploymentScheduleCreate(schedule=cron, active=True)]
    return client.create_deployment(
        flow_id=client.create_flow_from_name(named.name),
        name=each.name or each.flow,
        description=each.description,
        entrypoint=f"{named.fn.__module__}.{named.fn.__name__}",
        work_pool_name=each.pool,
        parameters={"order": dict(each.order)} if each.order or each.cron or each.alone else {},
        schedules=schedules,
        concurrency_limit=1 if each.alone else None,
        tags=[each.name] if each.name else [],
        job_variables={"env": environment(home)},
        parameter_openapi_schema=parameter_schema(named).model_dump_for_openapi(),
        enforce_parameter_schema=True,
        paused=False,
    )


def environment(home: Home) -> dict[str, str]:
    """What a worker gives the process of a run beside its own environment.

    What carries a password stays out of Prefect's database: the worker's environment has it.
    """
    named = {name: os.environ[name] for name in PASSED_ON if os.environ.get(name)}
    without = {name: value for name, value in named.items() if not has_secret(value)}
    return {"MIMUCAL_HOME": str(home.path.absolute())} | without | PATIENT
