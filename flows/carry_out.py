"""Carries out an order from the command line, as a Prefect flow run or directly in this process."""

from typing import Any

from schemas.orders import OrderModel


def carry_out(name: str, order: Any, of: str) -> Any:
    """Carry out an order: as a flow run if a Prefect server is named, otherwise in this process.

    name: of the flow in `prefect_flows`, and of the function in `run_orders`. of: the run or
    certificate it concerns, for the operator.
    """
    from flows.on_prefect.prefect_server import server_named

    if server_named():
        return as_flow_run(name, order)
    from flows import run_orders
    from flows.progress import working

    with working(f"{name} {of}"):
        return getattr(run_orders, name)(order)


def as_flow_run(name: str, order: OrderModel) -> Any:
    """Carry out an order as a flow run, on a server of our own if none is named.

    Signs it for whoever it names: the account that runs this command may read the home's key.
    """
    from flows.on_prefect.prefect_server import connect
    from flows.orders.signed_orders import sign
    from flows.run_orders import home_of

    order = sign(name, order)
    connect(home_of(order))
    from flows.on_prefect import prefect_flows

    return prefect_flows.run_now(getattr(prefect_flows, name), order)
