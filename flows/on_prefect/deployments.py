"""The deployments of a line on the Prefect server that PREFECT_API_URL names.

Each names a flow by its module: a worker needs mimucal installed, and no folder. Every station has
a work pool of its own that carries out one run at a time; the limit of a pool counts the runs in
the server's database, and so outlives the server. Import this module only after
`flows.on_prefect.prefect_server.connect`.
"""

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient
from prefect.client.schemas.actions import (
    DeploymentScheduleCreate,
    WorkPoolCreate,
    WorkPoolUpdate,
)
from prefect.client.schemas.schedules import CronSchedule
from prefect.exceptions import ObjectAlreadyExists, ObjectNotFound
from prefect.utilities.callables import parameter_schema
from prefect.workers.process import ProcessWorker

from flows.on_prefect import prefect_flows
from flows.on_prefect.automations import automate
from flows.on_prefect.client import prefect_client
from flows.on_prefect.prefect_queue import LINE, pool_of
from flows.on_prefect.worker import PATIENT
from schemas.base import Unusable
from schemas.secret_urls import has_secret
from storage.home import Home

AGAIN = "then repeat the command"
PASSED_ON = ("MIMUCAL_DATABASE", "MIMUCAL_STORE", "MIMUCAL_STATION")


@dataclass(frozen=True)
class Deployed:
    """A deployment. flow: its name in `prefect_flows`. alone: one run at a time.

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
    named: Any = getattr(prefect_flows, each.flow)
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
