"""Carries out an order from the command line, as a Prefect flow run or directly in this process."""

from collections.abc import Callable
from typing import TypeVar

from schemas.orders import OrderModel

Order = TypeVar("Order", bound=OrderModel)
Answer = TypeVar("Answer")


def carry_out(work: Callable[[Order], Answer], order: Order, of: str) -> Answer:
    """Carry out an order: as a flow run if a Prefect server is named, otherwise in this process.

    work: a function of `run_orders`. of: the run or certificate it concerns, for the operator.
    """
    from flows.on_prefect.prefect_server import server_named

    if server_named():
        return as_flow_run(work, order)
    from flows.progress import working

    with working(f"{work.__name__} {of}"):
        return work(order)


def as_flow_run(work: Callable[[Order], Answer], order: Order) -> Answer:
    """Carry out an order as a flow run, on a server of our own if none is named.

    Signs it for whoever it names: the account that runs this command may read the home's key.
    """
    from flows.on_prefect.prefect_server import connect
    from flows.orders.signed_orders import sign
    from flows.run_orders import home_of

    order = sign(work.__name__, order)
    connect(home_of(order))
    from flows.on_prefect import prefect_flows

    answer: Answer = prefect_flows.run_now(getattr(prefect_flows, work.__name__), order)
    return answer
