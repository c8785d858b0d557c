"""Where Prefect runs: an embedded server in the home, or the one that PREFECT_API_URL names."""

import os

from schemas.base import Unusable
from storage.home import Home

# What is set here must be in the environment before Prefect is imported for the first time.
QUIET = {
    # The sentence of Unusable is for us to print; a server of one's own still gets the logs.
    "PREFECT_LOGGING_HANDLERS_CONSOLE_LEVEL": "CRITICAL",
    "PREFECT_INTERNAL_LOGGING_LEVEL": "CRITICAL",
    "DO_NOT_TRACK": "1",
    "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
    "PREFECT_CLI_WRAP_LINES": "false",
}
EMBEDDED = {
    "PREFECT_LOGGING_LEVEL": "CRITICAL",
    "PREFECT_LOGGING_TO_API_ENABLED": "false",
    "PREFECT_SERVER_ALLOW_EPHEMERAL_MODE": "true",
    "PREFECT_SERVER_EPHEMERAL_STARTUP_TIMEOUT_SECONDS": "120",
}


def server_named() -> bool:
    """Whether the operator named a Prefect server; then every order is a flow run on it."""
    return bool(os.environ.get("PREFECT_API_URL"))


def prepare(home: Home) -> None:
    """Point Prefect at its server; the embedded one keeps its database in the home.

    What the operator set in the environment stays.
    """
    settings = dict(QUIET)
    if not server_named():
        place = home.prefect.absolute()
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Unusable(
                f"{place} cannot be made ({error.strerror}); name another folder in MIMUCAL_HOME"
            ) from error
        settings |= EMBEDDED | {"PREFECT_HOME": str(place)}
    for name, value in settings.items():
        os.environ.setdefault(name, value)
