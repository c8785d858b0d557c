"""Reads the environment variables of the program, in one place."""

import os

from pydantic import ValidationError

from schemas.base import Unusable
from schemas.environment import OWN, Environment, variables


def environment() -> Environment:
    """The variables as they are now; raises Unusable for a value that is none."""
    names = variables().values()
    given = {name: value for name in names if (value := os.environ.get(name))}
    try:
        return Environment.model_validate(given)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        raise Unusable(
            f"{fault['loc'][0]} is {fault['input']!r}: {fault['msg'].lower()}; correct it in the "
            "environment, or unset it."
        ) from error


def unknown() -> list[str]:
    """Variables that are named as if they were the program's, and are not."""
    known = variables().values()
    return sorted(name for name in os.environ if name.startswith(OWN) and name not in known)
