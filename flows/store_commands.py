"""The commands of the store: list, show, verify, doctor, prune, remind, validate."""

import sys
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flows import options
from schemas.base import BrokenOff, Unusable
from storage.home import home

if TYPE_CHECKING:
    from tasks.certificate.verify import VerifiedFile

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
            _verify_certificate(path, trust, as_json)
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


def _verify_certificate(path: Path, trust: Path | None, as_json: bool) -> None:
    """Prints what a certificate is, who signed it, and what is wrong with it; without the store."""
    from flows.terminal import print_json
    from tasks.certificate.verify import verify_file

    found = verify_file(path, _authorities(trust) if trust else ())
    if as_json:
        print_json(
            {
                "format": "mimu-verify/1",
                "checked": 1,
                "faults": [{"what": str(found.path), "why": why} for why in found.faults],
                "certificate": {
                    "number": found.number,
                    "state": found.state,
                    "record_sha256": found.record_sha256,
                    "signatures": [
                        asdict(each) | {"at": each.at.isoformat()} for each in found.signatures
                    ],
                },
            }
        )
    else:
        _print_verified(found, trusted=trust is not None)
    raise typer.Exit(1 if found.faults else 0)


def _authorities(path: Path) -> list[bytes]:
    from cryptography import x509
    from cryptography.hazmat.primitives.serialization import Encoding

    try:
        every = x509.load_pem_x509_certificates(path.read_bytes())
    except (OSError, ValueError) as error:
        raise Unusable(
            f"--trust {path} cannot be read; give a file with certificates as PEM."
        ) from error
    return [each.public_bytes(Encoding.DER) for each in every]


def _print_verified(found: "VerifiedFile", trusted: bool) -> None:
    for fault in found.faults:
        print(f"{found.path}: {fault}")
    if found.faults:
        return
    print(f"{found.path}: whole; certificate {found.number}, {found.state}")
    print(f"record sha256:{found.record_sha256}, which its QR code holds too")
    print("whether it was amended or withdrawn since, the laboratory knows")
    for each in found.signatures:
        stamped = " (time-stamped)" if each.time_stamped else ""
        print(f"signed by {each.by} at {each.at.isoformat()}{stamped}, under {each.authority}")
        print(f"  certificate of that authority: sha256:{each.authority_sha256}")
    if not found.signatures:
        print("not signed electronically: it is what mimucal makes of its record, by whomever")
    elif not trusted:
        print("whether that authority is the laboratory's is for you to know: compare, or --trust")


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
    from flows.terminal import print_json, print_rows
    from tasks.stages import remind

    now = datetime.now(UTC)
    if calendar is not None:
        sys.stdout.write(remind.feed(home(), calendar, now).decode())
        return
    faults = [] if dry_run else remind.remind(home(), now)
    due = remind.due_units(home(), now.astimezone().date() + timedelta(days=within))
    sent = remind.sent(home())
    if as_json:
        listed = [
            {"unit": each.unit, "certificate": each.certificate, "due": each.due.isoformat(),
             "sent": sent.get(each.certificate, [])}
            for each in due
        ]  # fmt: skip
        print_json({"format": "mimu-reminders/1", "due": listed})
    else:
        print_rows(
            f"Recalibration due within {within} days",
            ("unit", "client", "certificate", "due", "sent"),
            [
                (each.unit, each.client[0], each.certificate, each.due.isoformat(),
                 "; ".join(sent.get(each.certificate, [])))
                for each in due
            ],
        )  # fmt: skip
    if faults:
        raise BrokenOff(
            f"Not sent, and tried again by the next `mimucal remind`: {'; '.join(faults)}."
        )


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
    from flows.terminal import counting, print_rows, stdout
    from storage.settings import VALIDATION
    from storage.whole_files import writing_in_home
    from tasks.calibrate.calibrate import calibrate
    from tasks.specifications.register import SPECIFICATIONS
    from tasks.validation.coverage import MIN_UNITS, Calibrate
    from tasks.validation.make import make_record
    from tasks.validation.record import validation_html
    from tasks.version import code_version

    if out is None and units < MIN_UNITS:
        raise Unusable(
            f"--units {units}: a study of fewer than {MIN_UNITS} units shows nothing and would "
            "replace the record in the home; say with --out where it is to be written"
        )
    record_file = out or home().path / VALIDATION
    if record_file.suffix != ".json":
        raise Unusable(f"--out {record_file}: the record is a .json file; name it so")
    with counting(f"validate {len(SPECIFICATIONS)} methods") as report:
        methods: dict[str, Calibrate] = {
            name: partial(calibrate, spec) for name, spec in SPECIFICATIONS.items()
        }
        record = make_record(methods, units, seed, code_version(), report)
    text = record.model_dump_json(indent=1) + "\n"
    with writing_in_home(record_file):
        record_file.write_text(text, encoding="utf-8")
        record_file.with_suffix(".html").write_text(validation_html(record), encoding="utf-8")
    if as_json:
        print(text, end="")
        return
    rows = [
        (
            method,
            name,
            f"{100 * item.coverage.inside_95:.1f} %" if item.coverage else "-",
            f"{item.coverage.rms_z:.2f}" if item.coverage else "-",
            "yes" if item.valid else ", ".join(k for k, c in item.checks.items() if not c.passed),
        )
        for method, validation in record.methods.items()
        for name, item in validation.items.items()
    ]
    print_rows("Validation", ("method", "item", "inside 95 %", "rms z", "valid"), rows)
    console = stdout(markup=False)
    console.print(f"record {record_file}")
    console.print(f"page   {record_file.with_suffix('.html')}")
