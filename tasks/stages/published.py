"""A certificate as it stands in the store."""

from dataclasses import dataclass
from datetime import date
from pathlib import Path

from schemas.certificate import Certificate, State
from storage.catalogue.certificates import entry_of, record_of
from storage.home import Home


@dataclass(frozen=True)
class Published:
    """A certificate, what became of it, and where it lies.

    state: its record's own, or amended or withdrawn since.
    """

    certificate: Certificate
    state: State
    pdf: Path
    dcc: Path | None
    record: Path
    evidence: Path | None

    @property
    def due(self) -> date | None:
        """The day of recalibration; None once another certificate or none counts."""
        return None if self.state in ("amended", "withdrawn") else self.certificate.due


def published(number: str, home: Home) -> Published:
    """The certificate with a number, or the draft with a key; raises Unusable for none."""
    entry = entry_of(number, home)
    return Published(
        certificate=record_of(entry, home),
        state=entry.state,
        pdf=home.path / entry.pdf,
        dcc=home.path / entry.dcc if entry.dcc else None,
        record=home.path / entry.record,
        evidence=home.path / entry.evidence if entry.evidence else None,
    )
