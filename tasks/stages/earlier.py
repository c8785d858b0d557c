"""The issued certificates of a unit from before a calibration."""

from datetime import date

from schemas.base import Unusable
from schemas.certificate import Certificate
from storage.catalogue import certificates
from storage.catalogue.run_index import Run
from storage.home import Home

MOST = 20  # the last ones show how a unit moves


def earlier_certificates(run: Run, day: date | None, home: Home) -> list[Certificate]:
    """Records of the last issued certificates of a run's unit before a day, the oldest first.

    None where the day is not known. A record that cannot be read shows nothing: `verify` finds it.
    """
    if day is None:
        return []
    found = []
    for entry in certificates.issued_before(run, day, MOST, home):
        try:
            found.append(certificates.record_of(entry, home))
        except Unusable:
            continue
    return found
