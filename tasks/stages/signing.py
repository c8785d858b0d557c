"""The signing key of the laboratory to which a home belongs."""

import os
from datetime import datetime

from storage import settings
from storage.home import Home
from tasks.certificate.sign import Signing, signing_of

PASSPHRASE = "MIMUCAL_SIGNING_PASSPHRASE"


def signing_for(home: Home, at: datetime) -> Signing | None:
    """The key of `[signing]` in the home's laboratory.toml, opened; None where it names none."""
    laboratory = settings.laboratory(home)
    if laboratory is None or laboratory.signing is None:
        return None
    return signing_of(laboratory.signing, home.path, os.environ.get(PASSPHRASE), at)
