"""History made again by the processes of this machine, beside one core's bare estimation."""

import json
import os
import sys
from dataclasses import asdict, dataclass

from storage.home import Home
from tests.proof.history.watch import MIMUCAL, Watched, environment, watched

BARE = 100  # runs that the bare estimation is measured on
WORKERS = 2


@dataclass(frozen=True)
class Again:
    """What one re-processing took, beside the bare estimation of a recording by one core.

    stage_s: of the work itself, as the report has it; the rest of wall_s is the start of the
    program, and Prefect.
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
        """At most Prefect's share: its server, and everything of the command but the work."""
        return self.prefect_s / self.processor_s + (self.wall_s - self.stage_s) / self.wall_s


def bare(variables: dict[str, str]) -> tuple[float, float]:
    """Seconds of one estimation by one core, in wall and processor time."""
    command = [sys.executable, "-m", "tests.proof.history.bare", str(BARE)]
    measured = json.loads(watched(command, variables).out)
    return measured["wall_s"], measured["processor_s"]


def again(home: Home) -> Again:
    """Measures `mimucal reprocess` on every run of a home."""
    variables = environment(MIMUCAL_HOME=str(home.path))
    before = bare(variables)
    command = (*MIMUCAL, "reprocess", "--workers", str(WORKERS), "--json")
    return figures(watched(command, variables), before)


def figures(seen: Watched, of_one: tuple[float, float]) -> Again:
    """What a command's report and its cost say."""
    report = json.loads(seen.out)
    cost = {name: value for name, value in asdict(seen).items() if name != "out"}
    return Again(
        done=report["done"] - report["done_before"], failed=report["failed"],
        stage_s=report["seconds"], bare_s=of_one[0], bare_processor_s=of_one[1],
        load=os.getloadavg()[0], **cost,
    )  # fmt: skip
