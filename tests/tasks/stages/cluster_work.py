"""What the workers of the tests' dask clusters do: in a module, so that they can import it."""

import os
import time
from pathlib import Path


def squared(thing: int) -> int:
    return thing**2


def noted(thing: str) -> str:
    time.sleep(0.05)
    Path(thing).touch()
    return thing


def survived(thing: int) -> int:
    """All but the thirteenth, which kills its worker."""
    if thing == 13:
        os._exit(1)
    return thing


def waited(thing: int) -> int:
    time.sleep(0.05)
    return thing
