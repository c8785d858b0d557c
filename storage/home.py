"""The home folder, which holds everything."""

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

DEFAULT = "mimucal-data"


@dataclass(frozen=True)
class Home:
    """Where everything is kept; nothing is made before something is stored."""

    path: Path

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
    def acquiring(self) -> Path:
        """Raw recordings that a station is giving; they leave when they are whole runs."""
        return self.path / "acquiring"

    @property
    def acquired(self) -> Path:
        """Recordings of whole runs that are not in the catalogue yet."""
        return self.acquiring / "whole"

    @property
    def locks(self) -> Path:
        """One file for each station that was ever acquired from."""
        return self.path / "locks"

    @property
    def status(self) -> Path:
        """How the last run of each station stands, one file each."""
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
        return os.environ.get("MIMUCAL_DATABASE") or f"sqlite:///{file}"


def home() -> Home:
    """The home that MIMUCAL_HOME names, else `mimucal-data` in the current folder."""
    return Home(Path(os.environ.get("MIMUCAL_HOME") or DEFAULT).expanduser().absolute())
