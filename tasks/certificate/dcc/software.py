"""The software that made the certificate and its results."""

import re

from tasks.certificate.dcc.xml import Element, dcc, described, named
from tasks.certificate.fields import given

RELEASE = re.compile(r"\d{1,3}(\.\d{1,3}){0,3}")


def software(code_version: str) -> Element:
    """This program; its release as DCC wants it, the whole version beside it."""
    release = RELEASE.match(code_version)
    return dcc.software(
        named("mimucal"),
        dcc.release(f"v{release[0] if release else 0}"),
        dcc.type("application"),
        described(given(code_version)),
    )
