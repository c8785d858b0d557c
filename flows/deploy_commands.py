"""`mimucal deploy`, and the stations of a home: `mimucal station add|remove`."""

import os
import re
from importlib.resources import files
from pathlib import Path
from string import Template
from sysconfig import get_path
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

import typer

from flows import options
from schemas.base import Unusable
from storage.environment import environment
from storage.home import home
from storage.whole_files import drafted, writing_in_home

if TYPE_CHECKING:
    from storage.home import Home

app = typer.Typer()
LOCAL_ZONE = Path("/etc/localtime")


@app.command(epilog="Example: mimucal deploy --timezone Asia/Shanghai")
def deploy(timezone: options.Timezone = None) -> None:
    """Create or update the deployments of the line on the Prefect server that is named.

    Those of a station come with `mimucal station add`.
    """
    zone = _zone(timezone)
    _connect(home())
    from flows.on_prefect.deployments import deploy_line

    for name in deploy_line(home(), zone):
        print(name)
    print(f"schedules in {zone}; their worker: mimucal work")


@app.command(epilog="Example: mimucal work")
def work() -> None:
    """Be the worker of what needs no station: certificates, re-processing, schedules, alerts.

    That of a station is `mimucal station work ID`.
    """
    from flows.on_prefect.worker import work_for_line

    _named_server()
    work_for_line(home())


def add(
    station_file: options.Station,
    schedule: options.Schedule = None,
    timezone: options.Timezone = None,
) -> None:
    """Add a station to the home, or update it.

    Its station file goes to the home's stations. Where PREFECT_API_URL names a server, it gets a
    work pool of one run at a time and the deployment produce/ID there, and its worker a unit file.
    """
    from flows.on_prefect.prefect_server import server_named
    from schemas.station import StationFile
    from storage import settings
    from storage.stations import keep

    place, zone = home(), _zone(timezone)
    if schedule and not server_named():
        raise Unusable(
            "--schedule needs a Prefect server, which carries it out: set PREFECT_API_URL"
        )
    id_ = settings.read(Path(station_file), StationFile).station.id
    if not re.fullmatch(r"[\w.-]+", id_):
        raise Unusable(
            f"station.id is {id_!r}: give it letters, digits, dots, hyphens and underscores "
            "alone, for it names a work pool, a file and a service"
        )
    kept = keep(Path(station_file), place)
    print(f"station {id_}: {kept}")
    if not server_named():
        return
    _connect(place)
    from flows.on_prefect.deployments import deploy_station

    pool = deploy_station(id_, str(kept), place, schedule, zone)
    print(f"work pool {pool}, deployment produce/{id_}")
    print(f"its worker: {_write_unit(id_, place)}")


def remove(station: options.Added) -> None:
    """Remove a station from the home, and its pool and deployment from the Prefect server.

    What it measured stays.
    """
    from flows.on_prefect.prefect_server import server_named
    from storage.station_lock import is_held
    from storage.stations import file_of

    place = home()
    kept = file_of(station, place)
    if is_held(station, place):
        raise Unusable(f"a run is going on at station {station}: wait for its end, or stop it")
    if server_named():
        _connect(place)
        from flows.on_prefect.deployments import remove_station

        remove_station(station)
    kept.unlink()
    _unit_file(station, place).unlink(missing_ok=True)
    print(f"station {station} removed")


def _connect(home: "Home") -> None:
    from flows.on_prefect.prefect_server import connect

    _named_server()
    connect(home)


def _named_server() -> None:
    from flows.on_prefect.prefect_server import server_named

    if not server_named():
        raise Unusable("no Prefect server is named: set PREFECT_API_URL to one that runs")


def _zone(named: str | None) -> str:
    """A time zone that is known; that of this computer if none is named."""
    zone = named or os.environ.get("TZ") or _of_this_computer()
    try:
        ZoneInfo(zone)
    except (ValueError, OSError, LookupError) as error:
        raise Unusable(f"--timezone {zone} is not known: give one like Asia/Shanghai") from error
    return zone


def _of_this_computer() -> str:
    _, _, zone = str(LOCAL_ZONE.resolve()).partition("zoneinfo/")
    return zone or "UTC"


def _write_unit(station: str, home: "Home") -> Path:
    """The systemd unit of a station's worker, which finds its secrets by the name of the line."""
    text = (files("flows.on_prefect") / "systemd" / "mimucal-station.service").read_text(
        encoding="utf-8"
    )
    path = _unit_file(station, home)
    unit = Template(text).substitute(
        station=station, home=home.path, server=environment().prefect_server,
        bin=get_path("scripts"), line=_line(home), unit=path.name,
    )  # fmt: skip
    with writing_in_home(path), drafted(path) as draft:
        draft.write_text(unit, encoding="utf-8")
    return path


def _unit_file(station: str, home: "Home") -> Path:
    return home.path / "systemd" / f"{_line(home)}-station-{station}.service"


def _line(home: "Home") -> str:
    """The name of the line, which distinguishes units and variables of several lines on one
    computer: the home's folder name.
    """
    return re.sub(r"[^A-Za-z0-9_.-]", "-", home.path.name)
