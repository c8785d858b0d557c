"""How an order of the command line is carried out."""

from typing import Any


def ordered(name: str, **parameters: Any) -> Any:
    """Carry out an order: as a flow run where a Prefect server is named, else right here."""
    from flows.server import server_named
    from tasks.stages.estimate import check_method, check_uncertainty

    check_method(parameters.get("method"))
    check_uncertainty(parameters.get("uncertainty", "gum"))
    if server_named():
        return as_flow(name, **parameters)
    from flows import orders
    from flows.progress import working
    from tasks.stages import plain

    with working(f"{name} {parameters['reference']}"):
        return getattr(orders, name)(plain, **parameters)


def as_flow(name: str, **parameters: Any) -> Any:
    from flows.server import prepare
    from storage.home import home

    prepare(home())
    from flows import line

    return line.run_now(getattr(line, name), **parameters)
