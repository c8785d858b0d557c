"""Of the runs that a schedule owes, one is carried out, whichever starts first."""

from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from uuid import uuid4

import pytest
from prefect.client.schemas.objects import FlowRun, State, StateType
from prefect.context import FlowRunContext

from flows.on_prefect import queue
from flows.on_prefect.queue import one_of_those_due

DEPLOYMENT = uuid4()
BEGAN = datetime(2026, 11, 27, 8, tzinfo=UTC)


def run(minute: int, state: StateType = StateType.SCHEDULED, auto: bool = True) -> FlowRun:
    return FlowRun(
        id=uuid4(), flow_id=uuid4(), deployment_id=DEPLOYMENT, auto_scheduled=auto,
        expected_start_time=BEGAN + timedelta(minutes=minute), state_type=state,
        state=State(type=state),
    )  # fmt: skip


class Server:
    """What is due of the deployment, and what was cancelled of it."""

    def __init__(self, *due: FlowRun) -> None:
        self.due, self.cancelled = list(due), []

    def read_flow_runs(self, flow_run_filter: object) -> list[FlowRun]:
        return self.due

    def set_flow_run_state(self, run_id: object, state: State) -> None:
        assert state.type is StateType.CANCELLED
        self.cancelled.append(run_id)


@pytest.fixture
def carried_out(monkeypatch: pytest.MonkeyPatch):
    """Starts a run of those that are due; gives what its body did."""

    def start(own: FlowRun, server: Server) -> object:
        @contextmanager
        def client(**_: object):
            yield server

        context = SimpleNamespace(flow_run=own)
        monkeypatch.setattr(FlowRunContext, "get", classmethod(lambda cls: context))
        monkeypatch.setattr(queue, "get_client", client)
        return one_of_those_due(lambda order: f"done {order}")("it")

    return start


def test_the_first_that_starts_is_carried_out_and_cancels_what_waits(carried_out) -> None:
    """Else a schedule that repeats faster than its runs begin is never carried out."""
    own, *others = (run(minute) for minute in (0, 10, 20, 30))
    server = Server(own, *others)
    assert carried_out(own, server) == "done it"
    assert server.cancelled == [each.id for each in others]


def test_the_newest_is_carried_out_and_cancels_what_still_waits(carried_out) -> None:
    early, own = run(0), run(30)
    server = Server(early, own)
    assert carried_out(own, server) == "done it"
    assert server.cancelled == [early.id]


def test_a_newer_one_that_another_worker_took_is_left_to_it(carried_out) -> None:
    own, taken = run(0), run(10, StateType.RUNNING)
    server = Server(own, taken)
    assert carried_out(own, server).type is StateType.CANCELLED
    assert server.cancelled == []


def test_what_somebody_ordered_is_neither_cancelled_nor_counted(carried_out) -> None:
    own, ordered = run(0), run(10, auto=False)
    server = Server(own, ordered)
    assert carried_out(own, server) == "done it"
    assert carried_out(ordered, Server(own, ordered)) == "done it"
    assert server.cancelled == []
