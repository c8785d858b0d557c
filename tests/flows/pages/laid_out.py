"""What a page is made of: its components, and what people read in them."""

from collections.abc import Iterator
from typing import Any

# Properties of components that people read; of others, the names of things.
READ = {
    "children", "label", "placeholder", "title", "description", "alt", "aria-label", "rowData",
    "data", "figure", "columnDefs", "error", "data-ask",
}  # fmt: skip
IDENTIFIERS = {"type", "mode", "hovertemplate", "family"}


def components(shown: Any) -> Iterator[Any]:
    """Every component of a page, from the outside inwards."""
    if hasattr(shown, "to_plotly_json"):
        yield shown
        shown = list(shown.to_plotly_json()["props"].values())
    if isinstance(shown, list | tuple):
        for each in shown:
            yield from components(each)


def texts(shown: Any) -> Iterator[str]:
    """The texts that people read, of components or of what a certificate prints."""
    if hasattr(shown, "to_plotly_json"):
        props = shown.to_plotly_json()["props"]
        shown = [each for name, each in props.items() if name in READ]
    if isinstance(shown, dict):
        shown = [each for name, each in shown.items() if name not in IDENTIFIERS]
    if isinstance(shown, list | tuple):
        for each in shown:
            yield from texts(each)
    elif isinstance(shown, str):
        yield shown
