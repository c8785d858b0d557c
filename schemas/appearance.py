"""What a laboratory's certificates look like: its logo, its seal, its wording, its own layout."""

import base64
import binascii
from typing import Self

from pydantic import model_validator

from schemas.base import Frozen


class Appearance(Frozen):
    """The content of the laboratory's files, so that the same record gives the same pages anywhere.

    logo, seal: pictures (SVG, PNG, JPEG) as base64. template: Typst source that replaces
    tasks/certificate/certificate.typ; it may import only the files beside that one.
    """

    logo: str | None = None
    seal: str | None = None
    template: str | None = None

    @property
    def pictures(self) -> dict[str, bytes]:
        """Logo and seal by name, where given."""
        both = {"logo": self.logo, "seal": self.seal}
        return {name: base64.b64decode(text) for name, text in both.items() if text}

    @model_validator(mode="after")
    def _readable(self) -> Self:
        for name, text in (("logo", self.logo), ("seal", self.seal)):
            try:
                base64.b64decode(text or "", validate=True)
            except binascii.Error as error:
                raise ValueError(f"{name} is not base64") from error
        if self.template and '"@' in self.template:
            raise ValueError('the template imports a package ("@…"); copy what it needs into it')
        return self
