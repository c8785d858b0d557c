"""Reads the environment variables of the program, in one place."""

import os

from pydantic import ValidationError

from schemas.base import Unusable
from schemas.environment import OWN, Environment, variables
from schemas.secret_urls import login_apart, shown


def environment() -> Environment:
    """The variables as they are now; raises Unusable for a value that is none.

    User and password in the URL of the Prefect server are its login.
    """
    names = variables().values()
    given = {name: value for name in names if (value := os.environ.get(name))}
    try:
        found = Environment.model_validate(given)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        raise Unusable(
            f"{fault['loc'][0]} is {shown(str(fault['input']))!r}: {fault['msg'].lower()}; correct "
            "it in the environment, or unset it."
        ) from error
    server, user, password = login_apart(found.prefect_server or "")
    if user is None:
        return found
    login = found.prefect_login or f"{user}:{password or ''}"
    return found.model_copy(update={"prefect_server": server, "prefect_login": login})


def unknown() -> list[str]:
    """Variables that are named as if they were the program's, and are not."""
    known = variables().values()
    return sorted(name for name in os.environ if name.startswith(OWN) and name not in known)
