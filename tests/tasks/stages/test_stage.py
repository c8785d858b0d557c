"""A stage outside of a flow is its function; what it is within one, the flows' tests show."""

import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn

import pytest
from httpx import ConnectError, HTTPStatusError, Request, Response
from prefect.context import FlowRunContext, TaskRunContext

from schemas.base import Unusable
from tasks.stages import stage as module
from tasks.stages.stage import stage, without_loss


@stage("double")
def double(number: int) -> int:
    """Twice the number."""
    return 2 * number


def test_a_stage_keeps_its_function_and_its_documentation():
    assert double(3) == 6
    assert double.__doc__ == "Twice the number."


def test_a_stage_that_a_task_calls_is_part_of_that_task(monkeypatch):
    monkeypatch.setattr(FlowRunContext, "get", classmethod(lambda cls: object()))
    assert module._starts_a_task()
    monkeypatch.setattr(TaskRunContext, "get", classmethod(lambda cls: object()))
    assert not module._starts_a_task()
    assert double(3) == 6


def test_stages_are_imported_and_called_without_prefect():
    code = (
        "import sys\n"
        "from tasks.stages import acquire, certify, correct, estimate, explain, import_recording\n"
        "from tasks.stages.stage import stage\n"
        "assert stage('double')(lambda number: 2 * number)(3) == 6\n"
        "print('prefect' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def _gone() -> NoReturn:
    raise ConnectError("nobody listens")


def _server_ends_after(body: Callable[[int], int]) -> Callable[[int], Any]:
    def by_prefect(number: int) -> Any:
        with suppress(Unusable):
            body(number)
        _gone()

    return by_prefect


def test_what_a_function_gave_is_not_lost_with_the_server_that_was_to_hear_of_it():
    calls: list[int] = []

    def count(number: int) -> int:
        calls.append(number)
        return len(calls)

    assert without_loss(count, _server_ends_after)(3) == 1
    assert calls == [3]


def test_a_function_runs_without_a_server_that_ended_before_it_began():
    assert without_loss(lambda number: 2 * number, lambda body: lambda number: _gone())(3) == 6


def test_why_a_function_failed_is_not_lost_with_the_server():
    def refuse(number: int) -> int:
        raise Unusable("the sentence for the bench")

    with pytest.raises(Unusable, match="the sentence for the bench"):
        without_loss(refuse, _server_ends_after)(3)


@pytest.mark.parametrize("code", [410, 404, 500, 503])
def test_a_server_that_was_started_anew_and_forgot_the_run_costs_nothing(code):
    request = Request("POST", "http://127.0.0.1/api/leases")

    def forgotten(body: Callable[[int], int]) -> Callable[[int], Any]:
        def by_prefect(number: int) -> Any:
            body(number)
            raise HTTPStatusError("gone", request=request, response=Response(code))

        return by_prefect

    assert without_loss(lambda number: 2 * number, forgotten)(3) == 6
