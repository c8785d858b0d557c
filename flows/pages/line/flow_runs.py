"""What the Prefect server holds beside production orders, by deployment and subject."""

import time
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

from pydantic import ValidationError

from flows.on_prefect.prefect_server import server_named
from flows.pages.line.models import FlowRun, Flows
from storage.environment import environment
from tasks.stages import prefect_api

NOW = ("PENDING", "RUNNING", "PAUSED", "CANCELLING")
LATE = "Late"  # Prefect's name of a scheduled run whose time has passed
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
        is_late=run["state_name"] == LATE, expected_at=run["expected_start_time"],
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
