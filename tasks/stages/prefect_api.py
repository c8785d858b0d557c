"""What a request to the API of Prefect's server carries, where it asks for a name and password."""

import base64
import os

AUTH = "PREFECT_API_AUTH_STRING"  # `name:password`, for clients
SERVER_AUTH = "PREFECT_SERVER_API_AUTH_STRING"  # the same, for the server


def headers() -> dict[str, str]:
    """The header of HTTP basic authentication, if a name and password are set."""
    given = os.environ.get(AUTH)
    if not given:
        return {}
    return {"Authorization": f"Basic {base64.b64encode(given.encode()).decode()}"}
