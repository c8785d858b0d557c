"""What Prefect monitors: runs that are late, crashed or without heartbeat, and workers.

Import this module only after `flows.on_prefect.prefect_server.connect`.
"""

from collections.abc import Iterable
from datetime import timedelta
from typing import Any
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient
from prefect.client.schemas.objects import StateType
from prefect.events.actions import ChangeFlowRunState, RunDeployment
from prefect.events.schemas.automations import AutomationCore, EventTrigger, Posture

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
