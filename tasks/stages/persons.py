"""Who may take the next step of a certificate: by default nobody takes two."""

import unicodedata

from schemas.base import Unusable
from schemas.certificate import Certificate, StepName
from storage import settings
from storage.home import Home

DONE: dict[StepName, str] = {"draft": "drafted", "check": "checked", "issue": "issued"}


def check_person(certificate: Certificate, person: str, step: StepName, home: Home) -> None:
    """Raises Unusable for a person who took an earlier step, and for a draft of nobody.

    The laboratory of the home says whether they have to be different persons; where there is
    none, that of the certificate.
    """
    laboratory = settings.laboratory(home) or certificate.laboratory
    if laboratory is not None and not laboratory.separate_persons:
        return
    number, run = certificate.number, certificate.calibration.run
    if certificate.step("draft") is None:
        raise Unusable(
            f"{number} does not say who drafted it; certify run {run} again with --by NAME, or "
            "name the operator in laboratory.toml."
        )
    for earlier in certificate.steps:
        if _plain(earlier.person) == _plain(person):
            raise Unusable(
                f"{earlier.person} {DONE[earlier.step]} {number}, so another person must "
                f"{step} it; separate_persons = false in laboratory.toml lets one person take "
                "every step."
            )


def _plain(name: str) -> str:
    return " ".join(unicodedata.normalize("NFKC", name).split()).casefold()
