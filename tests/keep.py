"""A certificate into the catalogue as a test wants it: under its own number, with a made-up PDF."""

from dataclasses import dataclass

import sqlalchemy as sql

from schemas.certificate import Certificate
from storage.catalogue import audit_trail, certificates, database
from storage.home import Home

ACTIONS = {"draft": "draft", "checked": "check", "issued": "issue"}


@dataclass(frozen=True)
class MadeUp:
    """Faces of a certificate of which nothing but the record is real."""

    pdf: bytes
    record: bytes
    dcc: bytes = b"<dcc/>"
    evidence: bytes | None = None


def keep(certificate: Certificate, home: Home, pdf: bytes = b"%PDF") -> None:
    """Keeps a certificate as it stands, whatever steps it took."""
    faces = MadeUp(pdf, certificate.model_dump_json(indent=1).encode())
    with database.changing(home) as connection:
        certificates.add(connection, home, certificate, faces)
        hashes = certificates.hashes(connection, certificate.number)
        action = ACTIONS[certificate.state]
        audit_trail.add(connection, "test", action, certificate.number, sha256=hashes)


def take_number(home: Home, prefix: str = "MIMU", year: int = 2026) -> str:
    """The next number of a laboratory, for nothing."""
    with database.changing(home) as connection:
        series = certificates.series_of("{prefix}-{year}-{serial:04d}", prefix, year)
        return certificates.next_number(connection, series)


def by_force(home: Home, *statements: sql.Executable) -> None:
    """What somebody does who may do everything to the database."""
    with database.changing(home) as connection:
        for trigger in ("trail_no_update", "trail_no_delete"):
            connection.exec_driver_sql(f"DROP TRIGGER {trigger}")
        for statement in statements:
            connection.execute(statement)
