"""The register of specifications."""

from schemas.calibration import Method
from schemas.recording import Standard
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.specifications.specification import Specification

SPECIFICATIONS: dict[Method, Specification] = {
    specification.method: specification for specification in (JJF2003, JOINT, JJF1536)
}
BY_STANDARD: dict[Standard, Specification] = {
    "JJF 2003-2022": JJF2003,
    "JJF 1536-2015": JJF1536,
}


def specification_for(standard: Standard, method: Method | None = None) -> Specification:
    """That of a method, else the one a recording was made for; JJF 2003 where it names none."""
    return SPECIFICATIONS[method] if method else BY_STANDARD.get(standard, JJF2003)
