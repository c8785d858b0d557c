"""The commands of whoever operates it: backup, restore, upgrade, settings, alert."""

import typer

from flows import options
from schemas.base import Unusable
from storage.environment import environment, unknown
from storage.home import home
from tasks.version import code_version

app = typer.Typer()


@app.command(epilog="Example: mimucal backup /mnt/backup/line")
def backup(folder: options.BackupFolder, as_json: options.Json = False) -> None:
    """Add a backup of the home, its recordings and its catalogue to a folder.

    Runs may go on meanwhile. Only what the folder lacks is copied. It holds keys and passwords.
    Exits with 1 if something that the catalogue names is missing from the home.
    """
    from flows.printing import print_json
    from flows.progress import counting
    from storage.backup.back_up import back_up

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
    from flows.printing import print_json
    from flows.progress import counting
    from storage.backup.restore import restore as restore_into
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
    from flows.printing import print_json
    from flows.upgrading import confirmed, upgraded, went_back

    if confirm and back:
        raise Unusable("--confirm gives up the way back that --back takes: give one of them.")
    done = confirmed() if confirm else went_back() if back else upgraded()
    if as_json:
        print_json({"format": "mimu-upgrade/1", "done": done.done, "sentences": done.sentences})
    else:
        print("\n".join(done.sentences))
    raise typer.Exit(1 if done.done == "refused" else 0)


@app.command(epilog="Example: mimucal settings --json")
def settings(as_json: options.Json = False) -> None:
    """Show every environment variable of the program, its value and where it comes from.

    Exits with 1 if one is set that the program does not know.
    """
    from flows.printing import print_json, print_rows
    from schemas.environment import in_rows

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
    from flows.printing import print_json
    from tasks.stages.alert import alert as send_to_operators

    sent = send_to_operators(home(), text)
    if as_json:
        faults = {each.channel: each.fault for each in sent}
        print_json({"format": "mimu-alert/1", "channels": faults})
    else:
        for each in sent:
            print(f"{each.channel}: {each.fault or 'sent'}")
    raise typer.Exit(1 if any(each.fault for each in sent) else 0)
