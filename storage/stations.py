"""The stations of a home: their station files, in its `stations` folder."""

from contextlib import suppress
from pathlib import Path

from schemas.base import NotThere, Unusable
from schemas.station import StationFile
from storage import settings
from storage.home import Home
from storage.whole_files import drafted, writing_in_home


def folder_of(home: Home) -> Path:
    """Where a home keeps the files of its stations."""
    return home.path / "stations"


def station_files(home: Home) -> tuple[str, ...]:
    """The names of those files."""
    found = (path.name for path in folder_of(home).glob("*") if path.suffix in (".toml", ".json"))
    return tuple(sorted(name for name in found if not name.startswith(".")))


def station_ids(home: Home) -> tuple[str, ...]:
    """The ids of the home's stations, as far as their files can be read."""
    found = set()
    for name in station_files(home):
        with suppress(Unusable):
            found.add(settings.read(folder_of(home) / name, StationFile).station.id)
    return tuple(sorted(found))


def file_of(station: str, home: Home) -> Path:
    """The station file of the station with this id.

    Raises NotThere for one that is not among the home's, Unusable for one that is there twice.
    """
    files = [folder_of(home) / name for name in station_files(home)]
    found = [path for path in files if settings.read(path, StationFile).station.id == station]
    if not found:
        raise NotThere(
            f"{folder_of(home)} has no file of station {station}; add it with "
            "`mimucal station add FILE`"
        )
    if len(found) > 1:
        raise Unusable(
            f"{' and '.join(map(str, found))} are both of station {station}; keep the one that "
            "counts"
        )
    return found[0]


def file_named(station: str, home: Home) -> Path:
    """A station file by its path, or by the id of its station; raises Unusable as `file_of`."""
    path = Path(station)
    return path if path.suffix.lower() in settings.READERS else file_of(station, home)


def keep(file: Path, home: Home) -> Path:
    """Takes a station file among the home's, in the place of the one with its id; where it lies.

    Only the owner reads it: a link to a device may have a password.
    """
    id_ = settings.read(file, StationFile).station.id
    before = [folder_of(home) / name for name in station_files(home)]
    own = [path for path in before if settings.read(path, StationFile).station.id == id_]
    target = folder_of(home) / f"{id_}{file.suffix}"
    content = file.read_bytes()
    with writing_in_home(target), drafted(target) as draft:
        draft.write_bytes(content)
        draft.chmod(0o600)
    for path in own:
        if path != target:
            path.unlink()
    return target
