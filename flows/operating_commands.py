"""The commands of whoever operates it: backup, restore, upgrade, settings, alert."""

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
from storage.home import environment, home, unknown
from storage.whole_files import drafted, writing_in_home
from tasks.version import code_version

if TYPE_CHECKING:
    from storage.home import Home


app = typer.Typer()


@app.command(epilog="Example: mimucal backup /mnt/backup/line")
def backup(folder: options.BackupFolder, as_json: options.Json = False) -> None:
    """Add a backup of the home, its recordings and its catalogue to a folder.

    Runs may go on meanwhile. Only what the folder lacks is copied. It holds keys and passwords.
    Exits with 1 if something that the catalogue names is missing from the home.
    """
    from flows.terminal import counting, print_json
    from storage.backup import back_up

    with counting("backing up") as report:
        name, manifest = back_up(home(), folder, code_version(), report)
    size = sum(each.size for each in manifest.files)
    if as_json:
        print_json({
            "format": "mimu-backed-up/1", "backup": name, "revision": manifest.revision,
            "rows": {table.name: table.rows for table in manifest.tables},
            "files": len(manifest.files), "bytes": size, "missing": list(manifest.missing),
        })  # fmt: skip
    else:
        rows = sum(table.rows for table in manifest.tables)
        print(f"backup {name}: {rows} rows, {len(manifest.files)} files, {size / 2**20:.1f} MB")
        for each in manifest.missing:
            print(f"{each} is missing from the home: see `mimucal verify`")
    raise typer.Exit(1 if manifest.missing else 0)


@app.command(epilog="Example: mimucal restore /mnt/backup/line")
def restore(
    folder: options.BackupFolder,
    name: options.BackupName = None,
    as_json: options.Json = False,
) -> None:
    """Put a backup into an empty home, store and database, and verify all of it.

    Exits with 1 if faults are found.
    """
    from flows.terminal import counting, print_json
    from storage.backup import restore as restore_into
    from storage.verify import verify

    with counting("restoring") as report:
        restored, manifest = restore_into(folder, name, home(), report)
    with counting("verifying") as report:
        checked, faults = verify(home(), report)
    if as_json:
        print_json({
            "format": "mimu-restored/1", "backup": restored, "files": len(manifest.files),
            "checked": checked,
            "faults": [{"what": fault.what, "why": fault.why} for fault in faults],
        })  # fmt: skip
    else:
        print(f"restored {restored} to {home().path}: {checked} checked, {len(faults)} faults")
        for fault in faults:
            print(f"{fault.what}: {fault.why}")
    raise typer.Exit(1 if faults else 0)


@app.command(epilog="Example: mimucal upgrade")
def upgrade(
    confirm: options.Confirm = False, back: options.Back = False, as_json: options.Json = False
) -> None:
    """Bring a catalogue of an earlier version to this one, after a check on a copy.

    The way back stays until it is given up. Exits with 1, and changes nothing, if the check
    finds faults.
    """
    from flows.terminal import print_json
    from storage import backup

    if confirm and back:
        raise Unusable("--confirm gives up the way back that --back takes: give one of them.")
    if confirm:
        backup.confirm(home())
        done, sentences = "confirmed", ["The upgrade is confirmed; there is no way back."]
    else:
        done, sentences = _went_back() if back else _upgraded()
    if as_json:
        print_json({"format": "mimu-upgrade/1", "done": done, "sentences": sentences})
    else:
        print("\n".join(sentences))
    raise typer.Exit(1 if done == "refused" else 0)


def _upgraded() -> tuple[str, list[str]]:
    """Checks on a copy, then upgrades; refused where the check finds faults: nothing is changed."""
    from flows.terminal import counting, working
    from storage import backup
    from storage.catalogue.database import HEAD
    from tasks.version import code_version

    if not backup.is_needed(home()):
        return "nothing", ["The catalogue needs no upgrade."]
    with counting("checking on a copy") as report:
        faults = backup.rehearse(home(), code_version(), report)
    if faults:
        found = [f"{fault.what}: {fault.why}" for fault in faults]
        end = "Nothing was changed: put this right with the version of mimucal that made it."
        return "refused", [*found, end]
    with working("upgrading"):
        before = backup.upgrade(home(), code_version())
    return "upgraded", [
        f"The catalogue is upgraded from revision {before} to {HEAD}.",
        "The way back stays until `mimucal upgrade --confirm`; `mimucal upgrade --back` takes it.",
    ]


def _went_back() -> tuple[str, list[str]]:
    from flows.terminal import working
    from storage import backup
    from tasks.version import code_version

    with working("going back"):
        revision, newer = backup.back(home(), code_version())
    rows = ", ".join(f"{count} of {name}" for name, count in newer.items())
    kept = f"Left out, and kept in {home().path / 'upgrade-left'}: rows that came since: {rows}."
    done = f"The catalogue is back at revision {revision}: go on with the version that made it."
    return "back", [done, *([kept] if newer else [])]


@app.command(epilog="Example: mimucal settings --json")
def settings(as_json: options.Json = False) -> None:
    """Show every environment variable of the program, its value and where it comes from.

    Exits with 1 if one is set that the program does not know.
    """
    from flows.terminal import print_json, print_rows
    from schemas.laboratory import in_rows

    rows, strange = in_rows(environment()), unknown()
    if as_json:
        print_json({
            "format": "mimu-settings/1",
            "settings": [
                {"variable": row.variable, "value": row.value, "source": row.source,
                 "what": row.what} for row in rows
            ],
            "unknown": strange,
        })  # fmt: skip
    else:
        print_rows(
            "Settings",
            ("variable", "value", "source", "what it is"),
            [(row.variable, row.value or "", row.source, row.what) for row in rows],
        )
        for name in strange:
            print(f"{name} is set, and is no variable of mimucal: correct its name, or unset it")
    raise typer.Exit(1 if strange else 0)


@app.command(epilog='Example: mimucal alert "the backup of line 2 failed"')
def alert(text: options.AlertText, as_json: options.Json = False) -> None:
    """Send a sentence to the operators that recall.toml names.

    Exits with 1 if a channel did not take it.
    """
    from flows.terminal import print_json
    from tasks.stages.remind import alert as send_to_operators

    sent = send_to_operators(home(), text)
    if as_json:
        faults = {each.channel: each.fault for each in sent}
        print_json({"format": "mimu-alert/1", "channels": faults})
    else:
        for each in sent:
            print(f"{each.channel}: {each.fault or 'sent'}")
    raise typer.Exit(1 if any(each.fault for each in sent) else 0)


# `mimucal deploy`, and the stations of a home: `mimucal station add|remove`.

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
    from flows.on_prefect.queue import work_for_line

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
    from flows.on_prefect.server import server_named
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
    from flows.on_prefect.server import server_named
    from storage.stations import file_of, is_held

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
    from flows.on_prefect.server import connect

    _named_server()
    connect(home)


def _named_server() -> None:
    from flows.on_prefect.server import server_named

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
