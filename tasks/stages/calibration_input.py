"""The calibration that an order refers to."""

import os
from pathlib import Path

from schemas.base import Unusable
from schemas.calibration import Calibration
from storage import settings
from storage.catalogue import results
from storage.home import Home


def read_calibration(reference: str, home: Home) -> Calibration:
    """A result by its id or its run's in the store, or from a mimu-calibration/1 file.

    Raises Unusable for none of these.
    """
    # returns False for text that cannot be a path, where Path.is_file raises
    if os.path.isfile(reference):
        return settings.read(Path(reference), Calibration)
    return results.find(reference, home).calibration


def correcting_calibration(reference: str, home: Home) -> Calibration:
    """The same, to correct readings with; Unusable for that of an invalid run, too."""
    calibration = read_calibration(reference, home)
    validity = calibration.validity
    if validity.verdict == "invalid":
        raise Unusable(
            f"run {calibration.run} is invalid: {validity.reasons[0].rstrip('.')}; nothing is "
            "corrected by it: measure again."
        )
    return calibration
