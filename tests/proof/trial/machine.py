"""What a trial was held on: its figures can be had again with the same."""

import os
import platform
from dataclasses import dataclass
from importlib.metadata import version


@dataclass(frozen=True)
class Machine:
    """Versions of what computes, and the cores that it computed on."""

    python: str
    numpy: str
    scipy: str
    mimucal: str
    system: str
    cores: int


def this_machine() -> Machine:
    """The one that this runs on; cores: those that this process may use."""
    return Machine(
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
        mimucal=version("mimucal"),
        system=f"{platform.system()} {platform.machine()}",
        cores=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else
        os.cpu_count() or 1,
    )  # fmt: skip
