"""The client of the Prefect server that PREFECT_API_URL names."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from schemas.base import Unusable
from storage.environment import environment
from tasks.stages.prefect_api import CLIENT_AUTH, SERVER_AUTH, is_refusal
from tasks.words import message

if TYPE_CHECKING:
    from prefect.client.orchestration import SyncPrefectClient


@contextmanager
def prefect_client(otherwise: str) -> "Iterator[SyncPrefectClient]":
    """A client of the server; what it refuses or does not answer raises Unusable.

    otherwise: the end of that sentence. Call `flows.on_prefect.prefect_server.connect` before.
    """
    from httpx import HTTPError
    from prefect.client.orchestration import get_client

    try:
        with get_client(sync_client=True) as client:
            yield client
    except (HTTPError, RuntimeError) as error:  # the latter where it cannot be reached
        why = (
            f"refused {CLIENT_AUTH}: set it to the server's {SERVER_AUTH}"
            if is_refusal(error)
            else f"did not answer ({error}): start it, or mend PREFECT_API_URL"
        )
        raise Unusable(
            f"Prefect's server {environment().prefect_server} {why}; {otherwise}",
            message("station-cause.no-server"),
        ) from error
