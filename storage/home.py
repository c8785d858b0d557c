"""The home folder, which holds everything."""

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from pydantic import ValidationError

from schemas.base import Unusable, login_apart, shown
from schemas.laboratory import OWN, Environment, variables

# Reads the environment variables of the program, in one place.


def environment() -> Environment:
    """The variables as they are now; raises Unusable for a value that is none.

    User and password in the URL of the Prefect server are its login.
    """
    names = variables().values()
    given = {name: value for name in names if (value := os.environ.get(name))}
    try:
        found = Environment.model_validate(given)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        raise Unusable(
            f"{fault['loc'][0]} is {shown(str(fault['input']))!r}: {fault['msg'].lower()}; correct "
            "it in the environment, or unset it."
        ) from error
    server, user, password = login_apart(found.prefect_server or "")
    if user is None:
        return found
    login = found.prefect_login or f"{user}:{password or ''}"
    return found.model_copy(update={"prefect_server": server, "prefect_login": login})


def unknown() -> list[str]:
    """Variables that are named as if they were the program's, and are not."""
    known = variables().values()
    return sorted(name for name in os.environ if name.startswith(OWN) and name not in known)


RESTORING = "restoring"  # a file in a home into which a backup is being put: its name


@dataclass(frozen=True)
class Home:
    """Where everything is kept; nothing is made before something is stored.

    catalogue: the URL of a copy of the catalogue, in place of the one that the environment names.
    """

    path: Path
    catalogue: str | None = None

    @property
    def raw(self) -> Path:
        """Raw recordings, `<digest>.mcap`."""
        return self.path / "raw"

    @property
    def columns(self) -> Path:
        """The same recordings as columns, `<digest>/`; can be made again from raw."""
        return self.path / "columns"

    @property
    def certificates(self) -> Path:
        """What was printed, and the record it was printed from."""
        return self.path / "certificates"

    @property
    def tolerances(self) -> Path:
        """The limits of each product model, one TOML or JSON file each."""
        return self.path / "tolerances"

    @property
    def station_side(self) -> Path:
        """What a station needs while it runs: a folder on its own computer, which MIMUCAL_STATION
        names where the home is on another; else the home.
        """
        named = environment().station
        return self.path if named is None else named.expanduser().absolute()

    @property
    def acquiring(self) -> Path:
        """Raw recordings that a station is giving; they leave when they are whole runs."""
        return self.station_side / "acquiring"

    @property
    def acquired(self) -> Path:
        """Recordings of whole runs that are not in the catalogue yet."""
        return self.acquiring / "whole"

    @property
    def locks(self) -> Path:
        """Lock, stop request and station file of each station that was ever acquired from."""
        return self.station_side / "locks"

    @property
    def station_status(self) -> Path:
        """How the last run of each station of this computer stands, one file each."""
        return self.station_side / "status"

    @property
    def shared_locks(self) -> Path:
        """Where a stop request lies that another computer made."""
        return self.path / "locks"

    @property
    def status(self) -> Path:
        """The same as `station_status` of every station, for other computers."""
        return self.path / "status"

    @property
    def prefect(self) -> Path:
        """What the embedded Prefect server keeps."""
        return self.path / "prefect"

    @property
    def demo(self) -> Path:
        """Station file and truth of the demonstration's virtual station."""
        return self.path / "demo"

    @property
    def database_url(self) -> str:
        """The catalogue: MIMUCAL_DATABASE, else a SQLite file in the home."""
        file = quote(str(self.path / "catalog.sqlite"))
        return self.catalogue or environment().database or f"sqlite:///{file}"


def home() -> Home:
    """The home that MIMUCAL_HOME names, else `mimucal-data` in the current folder."""
    return Home(environment().home.expanduser().absolute())
