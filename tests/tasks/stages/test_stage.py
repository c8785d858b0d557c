"""A stage outside of a flow is its function; what it is within one, the flows' tests show."""

import subprocess
import sys

from prefect.context import FlowRunContext, TaskRunContext

from tasks.stages import stage as module
from tasks.stages.stage import stage


@stage("double")
def double(number: int) -> int:
    """Twice the number."""
    return 2 * number


def test_a_stage_keeps_its_function_and_its_documentation() -> None:
    assert double(3) == 6
    assert double.__doc__ == "Twice the number."


def test_a_stage_that_a_task_calls_is_part_of_that_task(monkeypatch) -> None:
    monkeypatch.setattr(FlowRunContext, "get", classmethod(lambda cls: object()))
    assert module._starts_a_task()
    monkeypatch.setattr(TaskRunContext, "get", classmethod(lambda cls: object()))
    assert not module._starts_a_task()
    assert double(3) == 6


def test_stages_are_imported_and_called_without_prefect() -> None:
    code = (
        "import sys\n"
        "from tasks.stages import acquire, certify, estimate, explain, import_recording, simulate\n"
        "from tasks.stages.stage import stage\n"
        "assert stage('double')(lambda number: 2 * number)(3) == 6\n"
        "print('prefect' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
