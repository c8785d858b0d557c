"""The procedure that an order names."""

from pathlib import Path

from schemas.procedure import Procedure
from storage import settings
from tasks.station import procedures

FILES = (".toml", ".json")


def procedure_named(name: str) -> Procedure:
    """The procedure of a file, or that of a name; raises Unusable where there is neither."""
    if Path(name).suffix in FILES:
        return settings.read(Path(name), Procedure)
    return procedures.load(name)
