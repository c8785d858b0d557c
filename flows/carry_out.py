"""Carries out an order from the command line, as a Prefect flow run or directly in this process."""

from collections.abc import Callable
from typing import TypeVar

from flows.execute import home_of
from flows.on_prefect.server import connect, server_named
from flows.terminal import working
from schemas.orders import OrderModel

Order = TypeVar("Order", bound=OrderModel)
Answer = TypeVar("Answer")


def carry_out(work: Callable[[Order], Answer], order: Order, of: str) -> Answer:
    """Carry out an order: as a flow run if a Prefect server is named, otherwise in this process.

    work: a function of `flows.execute`, or `produce`. of: the run or certificate it concerns, for
    the operator.
    """
    if server_named():
        return as_flow_run(work, order)
    with working(f"{work.__name__} {of}"):
        return work(order)


def as_flow_run(work: Callable[[Order], Answer], order: Order) -> Answer:
    """Carry out an order as a flow run, on a server of our own if none is named.

    Signs it for whoever it names: the account that runs this command may read the home's key.
    """
    from flows.orders.signed_orders import sign  # late: without a server nothing is signed

    order = sign(work.__name__, order)
    connect(home_of(order), import_flows)
    from flows.on_prefect import flows

    answer: Answer = flows.run_now(getattr(flows, work.__name__), order)
    return answer


def import_flows() -> None:
    """Half a second, while a server of our own starts."""
    from flows.on_prefect import flows  # noqa: F401
