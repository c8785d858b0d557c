"""What a certificate has to state: clause 8 of the specifications and ISO/IEC 17025, 7.8, as data.

Title, number, pages, place of the seal, name of the object, method, day of issue and scope stand on
every certificate, whatever is given; `deploy/guide/clause-8.md` has them beside those below.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from schemas.certificate import Certificate, Laboratory, Party
from schemas.laboratory import MeasurementStandard
from schemas.recording import Standard
from schemas.text import Statement, text_of
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Message, message


@dataclass(frozen=True)
class Required:
    """One entry of clause 8: its letter there, its place in ISO/IEC 17025, and whether it is given.

    name: of the messages that say what it is and where it is given. of_result: whether it is of a
    result, which an invalid run does not have.
    """

    name: str
    letter: str
    iso: str
    is_stated: Callable[[Certificate], bool]
    of_result: bool = False

    @property
    def what(self) -> Message:
        """Its name in words."""
        return message(f"mandatory-what.{self.name}")

    @property
    def sentence(self) -> Message:
        """That it is missing, by which clause, and where to give it."""
        return message(
            "mandatory-missing", what=self.what, letter=self.letter, iso=self.iso,
            where=message(f"mandatory-where.{self.name}"),
        )  # fmt: skip


def _of_laboratory(name: str) -> Callable[[Certificate], bool]:
    return lambda made: _of_party(made.laboratory.party if made.laboratory else None, name)


def _of_client(name: str) -> Callable[[Certificate], bool]:
    return lambda made: _of_party(made.order.client if made.order else None, name)


def _of_party(party: Party | None, name: str) -> bool:
    return party is not None and text_of(party, name) is not None


def _of_unit(name: str) -> Callable[[Certificate], bool]:
    return lambda made: bool(getattr(made.manifest.unit, name).strip())


def _of_standards(
    is_stated: Callable[[MeasurementStandard], bool],
) -> Callable[[Certificate], bool]:
    """Of every standard; true where none is listed, which is an entry of its own."""
    return lambda made: all(map(is_stated, standards_of(made)))


def _has_values(made: Certificate) -> bool:
    items = made.calibration.items.values()
    return any(value is not None for item in items for value in item.value.values())


def _has_uncertainties(made: Certificate) -> bool:
    """Of every value that the certificate gives as a result."""
    return all(
        item.U.get(element) is not None
        for item in made.calibration.items.values()
        for element, value in item.value.items()
        if value is not None
    )


def _has_title(made: Certificate) -> bool:
    """Of who issued it; until then, of anybody who may."""
    if made.state == "issued":
        return issuer_title(made) is not None
    laboratory = made.laboratory
    if laboratory is None:
        return False
    issuers = (each for each in laboratory.authorised if "issue" in each.may)
    titles = (text_of(laboratory, "issuer_title"), *(text_of(each, "title") for each in issuers))
    return any(titles)


def standards_of(certificate: Certificate) -> tuple[MeasurementStandard, ...]:
    """The measurement standards that a certificate lists."""
    return certificate.laboratory.equipment if certificate.laboratory else ()


def title_of(laboratory: Laboratory | None, person: str) -> Statement | None:
    """The title of a person by a laboratory."""
    if laboratory is None:
        return None
    own = (text_of(each, "title") for each in laboratory.authorised if each.name == person)
    if title := next(filter(None, own), None):
        return title
    if laboratory.issuer and person != laboratory.issuer:
        return None
    return text_of(laboratory, "issuer_title")


def issuer_title(certificate: Certificate) -> Statement | None:
    """The title of who issued a certificate, as it was kept."""
    step = certificate.step("issue")
    if step and (title := text_of(step, "title")):
        return title
    issuer = certificate.laboratory.issuer if certificate.laboratory else None
    return title_of(certificate.laboratory, step.person if step else issuer or "")


CLAUSE_8 = (
    Required("laboratory", "b)", "7.8.2.1 b)", _of_laboratory("name")),
    Required("laboratory-address", "b)", "7.8.2.1 b), c)", _of_laboratory("address")),
    Required("client", "e)", "7.8.2.1 e)", _of_client("name")),
    Required("client-address", "e)", "7.8.2.1 e)", _of_client("address")),
    Required("manufacturer", "f)", "7.8.2.1 g)", _of_unit("manufacturer")),
    Required("model", "f)", "7.8.2.1 g)", _of_unit("model")),
    Required("serial", "f)", "7.8.2.1 g)", _of_unit("serial")),
    Required("received", "g)", "7.8.2.1 h)", lambda made: made.order is not None),
    Required("calibrated", "g)", "7.8.2.1 i)", lambda made: made.calibrated_on is not None),
    Required("standards", "h)", "7.8.4.1 c)", lambda made: bool(standards_of(made))),
    Required("standard-name", "h)", "7.8.4.1 c)", _of_standards(
        lambda each: text_of(each, "name") is not None)),
    Required("standard-serial", "h)", "7.8.4.1 c)", _of_standards(
        lambda each: bool(each.serial.strip()))),
    Required("standard-accuracy", "h)", "7.8.4.1 c)", _of_standards(
        lambda each: bool(text_of(each, "accuracy") or each.limits or each.functions))),
    Required("standard-certificate", "h)", "7.8.4.1 c)", _of_standards(
        lambda each: bool(each.certificate.strip()))),
    Required("temperature", "i)", "7.8.4.1 b)",
             lambda made: made.calibration.environment.temperature_degc is not None),
    Required("humidity", "i)", "7.8.4.1 b)",
             lambda made: made.calibration.environment.humidity_percent is not None),
    Required("results", "j)", "7.8.2.1 m)", _has_values, of_result=True),
    Required("uncertainty", "j)", "7.8.4.1 a)", _has_uncertainties, of_result=True),
    Required("issuer", "k)", "7.8.2.1 o)",
             lambda made: made.state != "issued" or made.step("issue") is not None),
    Required("issuer-title", "k)", "7.8.2.1 o)", _has_title),
    Required("operator", "l)", "7.8.2.1 o)",
             lambda made: bool((made.carried_out_by or "").strip())),
    Required("checker", "l)", "7.8.2.1 o)",
             lambda made: made.state == "draft" or made.step("check") is not None),
)  # fmt: skip
# Both list the same, under the same letters.
MANDATORY: Mapping[Standard, tuple[Required, ...]] = {
    "JJF 2003-2022": CLAUSE_8,
    "JJF 1536-2015": CLAUSE_8,
}


def unstated(certificate: Certificate) -> tuple[Required, ...]:
    """What clause 8 asks for and a certificate does not state, as far as it has come."""
    invalid = certificate.calibration.validity.verdict == "invalid"
    return tuple(
        each
        for each in MANDATORY[SPECIFICATIONS[certificate.calibration.method].standard]
        if not (invalid and each.of_result) and not each.is_stated(certificate)
    )


def missing(certificate: Certificate) -> tuple[Message, ...]:
    """A sentence for everything that keeps a certificate from being one.

    None for a report, which states what it leaves out as the client agreed to it.
    """
    return () if certificate.report else tuple(each.sentence for each in unstated(certificate))
