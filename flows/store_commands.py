"""The commands of the store: list, show, verify, doctor, prune, remind, validate."""

from dataclasses import asdict

import typer

from flows import options
from schemas.base import Unusable
from storage.home import home

app = typer.Typer()


@app.command(epilog="Example: mimucal runs --json")
def runs(as_json: options.Json = False) -> None:
    """List the runs in the store."""
    from flows.terminal import print_json, print_rows
    from storage.catalogue import runs

    listed = runs.all_runs(home())
    if as_json:
        print_json(
            {"format": "mimu-runs/1", "runs": [run.model_dump(mode="json") for run in listed]}
        )
        return
    print_rows(
        "Runs",
        ("run", "recording", "unit", "standard", "imported", "seconds"),
        [
            (r.id, r.recording_id, f"{r.manufacturer} {r.model} {r.serial}", r.standard,
             f"{r.imported_at.astimezone():%Y-%m-%d %H:%M:%S}", f"{r.seconds:.0f}")
            for r in listed
        ],
    )  # fmt: skip


@app.command(epilog="Example: mimucal show r8b7e8cc74921 --log")
def show(run: options.Run, log: options.Log = False, as_json: options.Json = False) -> None:
    """Show a run: segments, results and certificates, or its log."""
    from flows.shown_results import show_log, show_run

    (show_log if log else show_run)(run, as_json)


@app.command(epilog="Example: mimucal verify")
def verify(
    path: options.Verified = None, trust: options.Trust = None, as_json: options.Json = False
) -> None:
    """Check the integrity of the store, of a recording, or of a certificate file on its own.

    Exits with 1 if faults are found.
    """
    from flows.terminal import counting, print_json

    if path is not None:
        from tasks.certificate.pdf import is_certificate

        if is_certificate(path):
            from flows.verify_certificate import run_verify_certificate

            run_verify_certificate(path, trust, as_json)
        from tasks.stages.import_recording import faults_of  # late: a certificate needs no store

        checked, faults = 1, faults_of(path)
    else:
        from storage.verify import verify as verify_store

        with counting("verifying") as report:
            checked, faults = verify_store(home(), report)
    if as_json:
        listed = [{"what": fault.what, "why": fault.why} for fault in faults]
        print_json({"format": "mimu-verify/1", "checked": checked, "faults": listed})
    else:
        print(f"{checked} checked, {len(faults)} faults")
        for fault in faults:
            print(f"{fault.what}: {fault.why}")
    raise typer.Exit(1 if faults else 0)


@app.command(epilog="Example: mimucal doctor")
def doctor(as_json: options.Json = False) -> None:
    """Diagnose problems of this installation and how to fix them.

    Exits with 1 if any are found.
    """
    from flows.terminal import print_rows
    from tasks.stages.doctor import diagnose

    diagnosis = diagnose(home())
    if as_json:
        print(diagnosis.model_dump_json(indent=1))
    else:
        rows = [(one.what, one.found, one.remedy or "") for one in diagnosis.examined]
        print_rows("Doctor", ("what", "found", "what to do"), rows)
        print(f"{len(diagnosis.faults)} of {len(rows)} need somebody to do something")
    raise typer.Exit(1 if diagnosis.faults else 0)


@app.command(epilog="Example: mimucal prune --before 2025-01-01")
def prune(
    before: options.Before,
    delete: options.Delete = False,
    by: options.DeletedBy = None,
    as_json: options.Json = False,
) -> None:
    """List or delete old data that nothing needs: unused recordings, and columns.

    Columns can be restored from raw data. Nothing is deleted without --delete; each deletion is
    entered in the audit trail.
    """
    from flows.shown_results import print_pruned
    from flows.terminal import counting
    from schemas.history import Pruned
    from storage import retention

    deleting = delete and options.person(by)
    found = retention.dispensable(before.date(), home())
    pruned = Pruned(before=before.date(), deleted=delete, found=tuple(found))
    if deleting:
        with counting("deleting") as report:
            gone, refused = retention.delete(found, deleting, home(), report)
        if not gone and len({each.why for each in refused}) == 1:  # all for one reason
            raise Unusable(refused[0].why)
        pruned = pruned.model_copy(update={"found": tuple(gone), "refused": tuple(refused)})
    if as_json:
        print(pruned.model_dump_json(indent=1))
    else:
        print_pruned(pruned)


@app.command(epilog="Example: mimucal remind --within 60")
def remind(
    within: options.Within = 30,
    calendar: options.CalendarOf = None,
    dry_run: options.NothingSent = False,
    as_json: options.Json = False,
) -> None:
    """Send the recalibration reminders that are due now, and list the units due.

    recall.toml in the home defines the recipients. With --calendar: print a client's due dates.
    Exits with 1 if a message could not be sent; the next call retries.
    """
    from flows.reminding import print_calendar, print_reminders

    if calendar is not None:
        print_calendar(calendar)
    else:
        print_reminders(within, dry_run, as_json)


@app.command(epilog="Example: mimucal interval V00001")
def interval(serial: options.OfUnit, as_json: options.Json = False) -> None:
    """Advise on a unit's recalibration interval, based on its own certificates.

    Uses the reliability method (NCSLI RP-1, ILAC-G24): 95 % within limits at its end.
    """
    from flows.terminal import print_json
    from tasks.stages.remind import interval_advice, sentence
    from tasks.words import say

    unit, agreed, advice = interval_advice(serial, home())
    if as_json:
        document = {"format": "mimu-interval/1", "unit": unit, "agreed_days": agreed}
        print_json(document | asdict(advice))
        return
    print(say(sentence(unit, agreed, advice)))


@app.command(epilog="Example: mimucal validate --units 2000")
def validate(
    units: options.Units = 2000,
    seed: options.Seed = 1,
    out: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Validate the estimation with simulated units and independent programs; keep the record.

    A unit passes only on items that a record of this version validates.
    """
    from flows.validate import run_validate

    run_validate(units, seed, out, as_json)
