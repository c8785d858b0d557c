"""Procedures as data: one TOML file each, named as the procedure."""

import tomllib
from importlib.resources import files

from schemas.base import Unusable
from schemas.procedure import Procedure


def names() -> tuple[str, ...]:
    """The procedures that come with the program."""
    entries = (entry.name for entry in files(__name__).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml")))


def load(name: str) -> Procedure:
    """The procedure of that name. Raises Unusable with the list of names if there is none."""
    if name not in names():
        raise Unusable(
            f"there is no procedure {name!r}: choose one of {', '.join(names())}, or give a file"
        )
    return Procedure.model_validate(
        tomllib.loads((files(__name__) / f"{name}.toml").read_text("utf-8"))
    )
