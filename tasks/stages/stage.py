"""Makes a plain function a stage: inside a Prefect flow it runs as a task of that flow.

Everywhere else it is the plain function that it was, and Prefect is not imported. Only this
module and the flows know Prefect.
"""

import logging
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial, wraps
from typing import TYPE_CHECKING, Any, NoReturn, ParamSpec, TypeVar, cast

from storage.catalogue.database import Busy

if TYPE_CHECKING:
    from prefect.client.schemas.objects import State, TaskRun
    from prefect.tasks import Task


# What happens on a line as events of Python's logging: a logger for each stage, below
# `mimucal.stage`; the devices of a station have theirs below `mimucal.station`.
#
# An event is a word (“begun”, “done”, “failed”) with its circumstances as fields; `flows/logs.py`
# writes them.

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


RETRIES = 2
RETRY_DELAY_S = 1
FORGOTTEN = (404, 410)  # a run or a lease that a server lost when it restarted


def stage(name: str, *, again: bool = True) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Makes a function a stage with the name that Prefect shows.

    again: whether it is tried again, twice, where the catalogue is locked by another process or
    out of reach. The run on a station is not: a unit that has begun to turn is never turned
    again by itself.
    """

    def staged(plain: Callable[P, R]) -> Callable[P, R]:
        function = logged(name, plain)

        @wraps(plain)
        def run(*args: P.args, **kwargs: P.kwargs) -> R:
            if not _starts_a_task():
                return function(*args, **kwargs)
            return without_loss(function, lambda body: _task(body, name, again))(*args, **kwargs)

        return run

    return staged


def notify(sentence: str) -> None:
    """Says something that the operator should know now: in the flow's log, else on stderr."""
    if _is_in_a_flow():
        from prefect.logging import get_run_logger

        get_run_logger().warning(sentence)
    else:
        with suppress(OSError):  # stderr is closed
            print(sentence, file=sys.stderr, flush=True)


def announce(event: str, unit: str, **payload: str) -> None:
    """Emits an event of a unit (its serial number) to Prefect, if a flow is running."""
    if _is_in_a_flow():
        from prefect.events import emit_event

        resource = {"prefect.resource.id": f"mimucal.unit.{unit}", "prefect.resource.name": unit}
        emit_event(f"mimucal.{event}", resource=resource, payload=payload)


def _is_in_a_flow() -> bool:
    if "prefect" not in sys.modules:
        return False
    from prefect.context import FlowRunContext, TaskRunContext

    return FlowRunContext.get() is not None or TaskRunContext.get() is not None


def _starts_a_task() -> bool:
    """Whether a flow is running, and none of its tasks: a stage that calls another is one task."""
    if "prefect" not in sys.modules:
        return False
    from prefect.context import FlowRunContext, TaskRunContext

    return FlowRunContext.get() is not None and TaskRunContext.get() is None


def without_loss(
    function: Callable[P, R], by_prefect: Callable[[Callable[P, R]], Callable[P, Any]]
) -> Callable[P, R]:
    """The function run by Prefect, whatever happens to Prefect's server meanwhile.

    A server that ends costs the record of the run, not the function's result or error; one that
    ended before, and could not be informed of the beginning, does not prevent it.
    """
    ends: list[Callable[[], R]] = []

    @wraps(function)
    def remembered(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            given = function(*args, **kwargs)
        except BaseException as fault:
            ends.append(partial(_again, fault))
            raise
        ends.append(lambda: given)
        return given

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return cast(R, by_prefect(remembered)(*args, **kwargs))
        except Exception as fault:
            if not is_of_the_server(fault):
                raise
            return ends[-1]() if ends else function(*args, **kwargs)

    return run


def is_of_the_server(fault: Exception) -> bool:
    """Whether it is away, refuses for a fault of its own, or has forgotten what it knew."""
    from httpx import HTTPStatusError, TransportError

    never_there = isinstance(fault, RuntimeError) and "Failed to reach API" in str(fault)
    refused = isinstance(fault, HTTPStatusError) and (
        fault.response.status_code in FORGOTTEN or fault.response.is_server_error
    )
    return never_there or refused or isinstance(fault, TransportError)


def _again(fault: BaseException) -> NoReturn:
    raise fault


def _task(function: Callable[P, R], name: str, again: bool) -> "Task[P, R]":
    from prefect import task
    from prefect.cache_policies import NO_CACHE

    return task(
        name=name,
        cache_policy=NO_CACHE,
        retries=RETRIES if again else 0,
        retry_delay_seconds=RETRY_DELAY_S,
        retry_condition_fn=_is_busy,
    )(function)


def _is_busy(task_: "Task[..., Any]", run: "TaskRun", state: "State[Any]") -> bool:
    return isinstance(state.result(raise_on_failure=False), Busy)
