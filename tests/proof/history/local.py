"""History made again by the processes of this machine, beside one core's bare estimation."""

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import nan

from storage.home import Home
from tests.proof.history.watch import MIMUCAL, environment, watched

BARE = 100  # runs that the bare estimation is measured on
WORKERS = 2
NOTHING_EVERY_S = 0.1  # of a command of five seconds, whose server is taken apart from the rest


@dataclass(frozen=True)
class Again:
    """What one re-processing took, beside the bare estimation of a recording by one core.

    stage_s: of the work itself, as the report has it; the rest of wall_s is the start of the
    program, and Prefect. prefect_s: processor time of Prefect's server, and of a command with
    nothing to do, less that of the same without a flow run.
    """

    done: int
    failed: int
    bare_s: float
    bare_processor_s: float
    wall_s: float
    stage_s: float
    processor_s: float
    prefect_s: float
    memory: int
    load: float

    @property
    def efficiency(self) -> float:
        """Of the work, against so many times one core's bare estimation."""
        return self.done * self.bare_s / (WORKERS * self.stage_s)

    @property
    def efficiency_of_command(self) -> float:
        return self.done * self.bare_s / (WORKERS * self.wall_s)

    @property
    def by_processor(self) -> float:
        """The bare estimation's share of all processor time: what else is busy does not show."""
        return self.done * self.bare_processor_s / self.processor_s

    @property
    def prefect(self) -> float:
        """Prefect's share of all processor time."""
        return self.prefect_s / self.processor_s


def _bare(variables: dict[str, str]) -> tuple[float, float]:
    """Seconds of one estimation by one core, in wall and processor time."""
    command = [sys.executable, "-m", "tests.proof.history.bare", str(BARE)]
    measured = json.loads(watched(command, variables).out)
    return measured["wall_s"], measured["processor_s"]


def again(home: Home) -> Again:
    """Measures `mimucal reprocess` on every run of a home."""
    variables = environment(MIMUCAL_HOME=str(home.path))
    return measured(("--workers", str(WORKERS)), variables)


def measured(
    engine: tuple[str, ...],
    variables: dict[str, str],
    meanwhile: Callable[[], None] | None = None,
) -> Again:
    """Measures `mimucal reprocess` with such options, where Prefect's database is made already.

    Bare estimation is measured before and after, since the machine is not equally fast all the
    time; where something disturbs `meanwhile`, it is not: it is one process that nobody retries.
    """
    command = (*MIMUCAL, "reprocess", *engine, "--json")
    nobody = (*command, "--until", "1900-01-01")
    for _ in range(2):  # the first makes Prefect's database
        nothing = watched(nobody, variables, every_s=NOTHING_EVERY_S)
    program = watched((*nobody, "--dry-run"), variables)  # needs no Prefect
    before = (nan, nan) if meanwhile else _bare(variables)
    observation = watched(command, variables, meanwhile or (lambda: None))
    load = os.getloadavg()[0]
    after = (nan, nan) if meanwhile else _bare(variables)
    report = json.loads(observation.out)
    # A server that stands is no child of the command.
    own_server_s = 0.0 if "PREFECT_API_URL" in variables else nothing.prefect_s
    return Again(
        done=report["done"] - report["done_before"],
        failed=report["failed"],
        bare_s=(before[0] + after[0]) / 2.0,
        bare_processor_s=(before[1] + after[1]) / 2.0,
        wall_s=observation.wall_s,
        stage_s=report["seconds"],
        processor_s=observation.processor_s,
        prefect_s=observation.prefect_s + nothing.command_s - own_server_s - program.command_s,
        memory=observation.memory,
        load=load,
    )
