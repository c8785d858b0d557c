"""Controls that reload a page with another question: each is a parameter of the address."""

from dash import ALL, ClientsideFunction, Dash, Input, Output, State


def asks(field: str, value: object) -> dict[str, str]:
    """The id of a control that asks for a field of the question and holds a value now."""
    return {"asks": field, "was": "" if value is None else str(value)}


def callbacks(app: Dash) -> None:
    """Another choice is another address."""
    control = {"asks": ALL, "was": ALL}
    app.clientside_callback(
        ClientsideFunction("asked", "ask"),
        Output("address", "search", allow_duplicate=True),
        Input(control, "value"),
        State(control, "id"),
        State("address", "search"),
        prevent_initial_call=True,
    )
