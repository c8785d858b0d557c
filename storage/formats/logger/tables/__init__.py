"""The kinds of file that a table comes in: one module for each, found by its SUFFIXES.

A module has `SUFFIXES`, in lower case and with their dots, and `read(path)`, which gives `Lines` or
a DataFrame. Reading one more kind of file is adding one module.
"""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import pandas as pd

TEXT = ".txt"


@dataclass(frozen=True)
class Lines:
    """A table as lines of text. separator: of their fields; None where that is to be found."""

    lines: list[str]
    separator: str | None = None


Content: TypeAlias = "Lines | pd.DataFrame"


@cache
def readers() -> dict[str, Any]:
    """The modules by their suffixes."""
    modules = [import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__)]
    return {suffix: module for module in modules for suffix in module.SUFFIXES}


def content(path: Path) -> Content:
    """What a file holds; of a suffix that nobody knows, as text.

    Raises Unusable, OSError or ValueError for what cannot be read.
    """
    found: Content = readers().get(path.suffix.lower(), readers()[TEXT]).read(path)
    return found
