"""The register of the laboratory's measurement standards: `mimucal equipment add|renew|list`."""

from datetime import date

import typer

from flows import options
from schemas.base import Unusable

app = typer.Typer(help="The laboratory's measurement standards, their certificates and due dates.")


@app.command(epilog='Example: mimucal equipment add turntable.toml --by "Wang Li"')
def add(file: options.EquipmentFile, by: options.By = None) -> None:
    """Add the measurement standards in a file to the register."""
    from schemas.equipment import EquipmentFile
    from storage import settings
    from storage.catalogue import equipment
    from storage.home import home

    given = settings.read(file, EquipmentFile).equipment
    equipment.add(given, home(), _person(by))
    print(f"{len(given)} taken into the register")


@app.command(epilog='Example: mimucal equipment renew turntable.toml --by "Wang Li"')
def renew(file: options.EquipmentFile, by: options.By = None) -> None:
    """Add new certificates in a file to standards of the register.

    Earlier ones are kept: a run uses the certificate that was valid on its day.
    """
    from schemas.equipment import EquipmentFile
    from storage import settings
    from storage.catalogue import equipment
    from storage.home import home

    given = settings.read(file, EquipmentFile).equipment
    equipment.renew(given, home(), _person(by))
    print(f"{len(given)} renewed")


@app.command(name="list", epilog="Example: mimucal equipment list --json")
def list_(as_json: options.Json = False) -> None:
    """List the standards with the certificates valid today."""
    from flows.printing import print_json, print_rows
    from storage.catalogue import equipment
    from storage.home import home

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
             ", ".join(s.limits), "PAST DUE" if s.serial in late else "")
            for s in standards
        ],
    )  # fmt: skip


def _person(by: str | None) -> str:
    if not by or not by.strip():
        raise Unusable("The register records who changes it; give --by NAME, or set MIMUCAL_USER.")
    return by
