"""A certificate as it stands in the store."""

from dataclasses import dataclass
from datetime import date
from pathlib import Path

from schemas.certificate import Certificate, State
from storage import settings
from storage.catalogue.certificates import entry_of, record_of
from storage.home import Home
from tasks.certificate.mandatory import missing
from tasks.words import Message


@dataclass(frozen=True)
class Published:
    """A certificate, what became of it, and where it lies.

    state: its record's own, or amended or withdrawn since. missing: what keeps a draft from being
    issued, a sentence for each entry of clause 8 that it does not state.
    """

    certificate: Certificate
    state: State
    pdf: Path
    dcc: Path | None
    record: Path
    evidence: Path | None
    missing: tuple[Message, ...]

    @property
    def due(self) -> date | None:
        """The day of recalibration; None once another certificate or none counts."""
        return None if self.state in ("amended", "withdrawn") else self.certificate.due


def published(number: str, home: Home) -> Published:
    """The certificate with a number, or the draft with a key; raises Unusable for none."""
    entry = entry_of(number, home)
    certificate = record_of(entry, home)
    return Published(
        certificate=certificate,
        state=entry.state,
        pdf=home.path / entry.pdf,
        dcc=home.path / entry.dcc if entry.dcc else None,
        record=home.path / entry.record,
        evidence=home.path / entry.evidence if entry.evidence else None,
        missing=_missing(certificate, home) if entry.state in ("draft", "checked") else (),
    )


def _missing(certificate: Certificate, home: Home) -> tuple[Message, ...]:
    """With the titles of those who may issue, which the record does not hold."""
    laboratory, own = certificate.laboratory, settings.laboratory(home)
    if laboratory and own:
        laboratory = laboratory.model_copy(update={"authorised": own.authorised})
    return missing(certificate.model_copy(update={"laboratory": laboratory}))
