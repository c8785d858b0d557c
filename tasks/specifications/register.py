"""The register of specifications."""

from schemas.calibration import OF_NO_STANDARD, OF_STANDARD, Method
from schemas.recording import Standard
from tasks.specifications.estimate import Specification
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT

SPECIFICATIONS: dict[Method, Specification] = {
    specification.method: specification for specification in (JJF2003, JOINT, JJF1536)
}
BY_STANDARD: dict[str, Specification] = {
    standard: SPECIFICATIONS[method] for standard, method in OF_STANDARD.items()
}


def specification_for(standard: Standard, method: Method | None = None) -> Specification:
    """That of a method, else the one a recording was made for; JJF 2003 where it names none."""
    return SPECIFICATIONS[method or OF_STANDARD.get(standard, OF_NO_STANDARD)]
