"""What happens on a line as events of Python's logging: a logger for each stage, below
`mimucal.stage`; the devices of a station have theirs below `mimucal.station`.

An event is a word (“begun”, “done”, “failed”) with its circumstances as fields; `flows/logs.py`
writes them.
"""

import logging
import time
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def logger_of(stage: str) -> logging.Logger:
    """The logger of a stage by its name."""
    return logging.getLogger(f"mimucal.stage.{stage.replace(' ', '-')}")


def logged(stage: str, function: Callable[P, R]) -> Callable[P, R]:
    """The function, whose beginning and end are events of its stage."""
    logger = logger_of(stage)

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        of, began_s = _subject(args), time.monotonic()
        logger.info("begun", extra={"of": of})
        try:
            given = function(*args, **kwargs)
        except BaseException as fault:
            seconds = round(time.monotonic() - began_s, 3)
            cause = str(fault) or type(fault).__name__
            logger.error("failed", extra={"of": of, "seconds": seconds, "cause": cause})
            raise
        logger.info("done", extra={"of": of, "seconds": round(time.monotonic() - began_s, 3)})
        return given

    return run


def _subject(args: tuple[Any, ...]) -> str:
    """What a stage is about, from its first argument: a run, a certificate, an order's station."""
    first = args[0] if args else ""
    for name in ("id", "station", "run"):
        if isinstance(found := getattr(first, name, None), str):
            return found
    return first if isinstance(first, str) else ""
