"""Explains every recording in a process of its own and measures what that costs."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MIB = 1024.0  # of ru_maxrss
THREADS = {"OPENBLAS_NUM_THREADS": "1"}  # so that processor time is that of one core


@dataclass(frozen=True)
class Cost:
    """Processor time, s, and the largest memory, MiB, of one explanation, from its start."""

    seconds: float
    memory: float


def explained(
    recording: Path, out: Path, program: Sequence[str] = (sys.executable, "-m", "flows.cli")
) -> tuple[Mapping[str, Any] | None, Cost]:
    """explain's JSON, kept in out/, and its cost; None where it refuses the recording."""
    environment = {**os.environ, **THREADS, "MIMUCAL_HOME": str(out / "home" / recording.name)}
    answer = out / f"{recording.name}.json"
    with answer.open("w", encoding="utf-8") as kept:
        ordered = [*program, "explain", str(recording), "--json"]
        process = subprocess.Popen(ordered, stdout=kept, env=environment)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    cost = Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / MIB)
    text = answer.read_text(encoding="utf-8")
    return (json.loads(text) if process.returncode == 0 else None), cost
