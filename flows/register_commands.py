"""Registers: `mimucal equipment`, the measurement standards; `mimucal user`, who may log in."""

import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from pydantic import ValidationError

from flows import options
from schemas.base import Unusable, first_fault
from storage.home import home
from storage.whole_files import written_out

if TYPE_CHECKING:
    from schemas.laboratory import MeasurementStandard

app = typer.Typer(help="The laboratory's measurement standards, their certificates and due dates.")


@app.command(epilog='Example: mimucal equipment add turntable.toml --by "Wang Li"')
def add(file: options.EquipmentFile, by: options.By = None) -> None:
    """Add the measurement standards in a file to the register."""
    from storage.catalogue import equipment

    print(f"{_kept(equipment.add, file, by)} taken into the register")


@app.command(epilog='Example: mimucal equipment renew turntable.toml --by "Wang Li"')
def renew(file: options.EquipmentFile, by: options.By = None) -> None:
    """Add new certificates in a file to standards of the register.

    Earlier ones are kept: a run uses the certificate that was valid on its day.
    """
    from storage.catalogue import equipment

    print(f"{_kept(equipment.renew, file, by)} renewed")


@app.command(
    name="import", epilog="Example: mimucal equipment import dcc.xml budgeted --out table.json"
)
def import_(
    file: options.StandardDcc,
    deviation: options.Deviation,
    out: options.Entry,
) -> None:
    """Write what a standard's own DCC (XML) states as an entry that `add` and `renew` read.

    Look it through first: a DCC does not say until when it is valid, or how the standard drifts.
    """
    from schemas.laboratory import EquipmentFile
    from storage.formats.standard_dcc import read_standard

    entry = EquipmentFile(equipment=(read_standard(file, deviation),))
    with written_out(out) as draft:
        draft.write_text(entry.model_dump_json(indent=1, exclude_unset=True), encoding="utf-8")
    (standard,) = entry.equipment
    for name, function in standard.functions.items():
        axes = ", ".join(axis for axis in function.axes if axis) or "every axis"
        print(f"{name}: {len(function.rows)} rows ({axes})")
    print(f"Look through {out}, complete valid_until, then: mimucal equipment add {out}")


@app.command(epilog="Example: mimucal equipment check T-1 --what rate --result 3e-6 --limit 1e-5")
def check(
    serial: options.OfStandard,
    what: options.Checked,
    result: options.CheckResult,
    limit: options.CheckLimit,
    unit: options.CheckUnit = "",
    translated: options.CheckedInChinese = "",
    on: options.CheckedOn = None,
    by: options.By = None,
) -> None:
    """Record an intermediate check of a standard; one beyond its limit prevents every pass."""
    from schemas.laboratory import IntermediateCheck
    from schemas.text import no_text
    from storage.catalogue import equipment

    day = on.date() if on else date.today()
    try:
        made = IntermediateCheck(
            **dict(zip(no_text("what"), (what, translated), strict=True)),
            checked_on=day,
            result=result,
            limit=limit,
            unit=unit,
        )
    except ValidationError as fault:
        raise Unusable(f"the check of {serial}: {first_fault(fault)}; correct it.") from fault
    checked = equipment.add_check(serial, made, home(), options.person(by))
    found = "passed" if made.passed else "FAILED: nothing passes with this standard"
    print(f"{serial}, certificate {checked.certificate}: {found}")


@app.command(name="list", epilog="Example: mimucal equipment list --json")
def list_(as_json: options.Json = False) -> None:
    """List the standards with the certificates valid today."""
    from flows.terminal import print_json, print_rows
    from storage.catalogue import equipment

    today = date.today()
    standards = list(equipment.on_day(home(), today).values())
    late = {standard.serial for standard in equipment.past_due(home(), today)}
    if as_json:
        listed = [
            standard.model_dump(mode="json") | {"past_due": standard.serial in late}
            for standard in standards
        ]
        print_json({"format": "mimu-equipment-list/1", "equipment": listed})
        return
    print_rows(
        "Equipment",
        ("serial", "name", "certificate", "calibrated", "valid until", "states", ""),
        [
            (s.serial, s.name, s.certificate, str(s.calibrated_on or ""), str(s.valid_until or ""),
             ", ".join((*s.limits, *s.functions)), _state(s, s.serial in late))
            for s in standards
        ],
    )  # fmt: skip


def _state(standard: "MeasurementStandard", late: bool) -> str:
    failed = not all(check.passed for check in standard.checks)
    return ", ".join(["PAST DUE"] * late + ["CHECK FAILED"] * failed)


def _kept(keep: Callable[..., None], file: Path, by: str | None) -> int:
    """How many standards of a file were kept in the register."""
    from schemas.laboratory import EquipmentFile
    from storage import settings

    given = settings.read(file, EquipmentFile).equipment
    keep(given, home(), options.person(by))
    return len(given)


# The users of the operations pages.


users = typer.Typer(help="Who may log in to the operations pages, and in which role.")
SHORTEST = 10  # characters of a password
LONGEST = 100  # characters of a name


@users.command(
    name="add", epilog='Example: mimucal user add "Wang Li" --role operator --by "Chen Jie"'
)
def add_user(name: options.UserName, role: options.UserRole, by: options.By = None) -> None:
    """Add a user, or change the role and password of one.

    The password is prompted for at a terminal, or read from the first line of standard input.
    """
    from flows.pages.login import hashed
    from schemas.access import ROLES
    from storage.catalogue import users

    chosen = next((each for each in ROLES if each == role), None)
    if chosen is None:
        raise Unusable(f"--role {role}: choose one of {', '.join(ROLES)}")
    if not 0 < len(name) <= LONGEST or name != name.strip():
        raise Unusable(
            f"{name[:LONGEST]!r} is not a valid user name; give 1 to {LONGEST} characters that "
            "neither begin nor end with a space."
        )
    users.add(name, chosen, hashed(_password(name)), home(), options.person(by))
    print(f"{name}: {chosen}")


@users.command(name="list", epilog="Example: mimucal user list")
def list_users(as_json: options.Json = False) -> None:
    """List the users and their roles."""
    from flows.terminal import print_json, print_rows
    from storage.catalogue import users

    every = users.users(home()).values()
    if as_json:
        shown = [each.model_dump(mode="json", exclude={"password"}) for each in every]
        print_json({"format": "mimu-users/1", "users": shown})
        return
    rows = [(each.name, each.role, f"{each.added_at:%F %R}") for each in every]
    print_rows("Users", ("name", "role", "since (UTC)"), rows)


@users.command(name="remove", epilog='Example: mimucal user remove "Wang Li"')
def remove_user(name: options.UserName, by: options.By = None) -> None:
    """Remove a user and end that user's sessions."""
    from storage.catalogue import users

    users.remove(name, home(), options.person(by))
    print(f"{name} removed")


def _password(name: str) -> str:
    if sys.stdin.isatty():
        given: str = typer.prompt(
            f"Password of {name}", hide_input=True, confirmation_prompt=True, err=True
        )
    else:
        given = sys.stdin.readline().rstrip("\n")
    if len(given) < SHORTEST:
        raise Unusable(f"The password has {len(given)} characters; give at least {SHORTEST}.")
    return given
