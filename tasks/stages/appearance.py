"""The logo, seal and layout named in a laboratory's file, as a certificate's record holds them."""

import base64
from pathlib import Path

from pydantic import ValidationError

from schemas.appearance import Appearance
from schemas.base import Unusable, first_fault
from schemas.certificate import Laboratory
from storage.home import Home

LARGEST = 2_000_000  # bytes of a file: each certificate holds it


def with_appearance(laboratory: Laboratory, home: Home) -> Laboratory:
    """The laboratory with the content of its files, if it names any.

    Raises Unusable for a file that cannot be read or is of the wrong kind.
    """
    named = {"logo": laboratory.logo, "seal": laboratory.seal, "template": laboratory.template}
    paths = {name: home.path / path for name, path in named.items() if path}
    if not paths:
        return laboratory
    held = {name: _held(name, path) for name, path in paths.items()}
    try:
        appearance = Appearance.model_validate(held)
    except ValidationError as error:
        raise Unusable(f"laboratory.toml: {first_fault(error)}.") from error
    return laboratory.model_copy(update={"appearance": appearance})


def _held(name: str, path: Path) -> str:
    """A layout as it stands, a picture in base64."""
    try:
        content = path.read_bytes()
        if len(content) > LARGEST:
            raise Unusable(
                f"laboratory.toml: {name} = {path} has {len(content):,} bytes, and every "
                f"certificate holds it: make it smaller than {LARGEST:,}."
            )
        return content.decode() if name == "template" else base64.b64encode(content).decode()
    except OSError as error:
        raise Unusable(
            f"laboratory.toml: {name} = {path} cannot be read ({error.strerror}); check that it "
            "exists and is readable."
        ) from error
    except UnicodeDecodeError as error:
        raise Unusable(f"laboratory.toml: {name} = {path} is not UTF-8; save it as UTF-8.") from (
            error
        )
