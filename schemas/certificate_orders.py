"""Orders of certificates: drafted, checked, issued, amended, withdrawn (see `orders`)."""

from datetime import date
from typing import Annotated

from pydantic import Field

from schemas.orders import AcquireOrder, CalibrateOrder, OrderModel

Person = Annotated[str, Field(min_length=1, pattern=r"\S")]


class CertificateOptions(OrderModel):
    """Inputs of a certificate beside the result; null leaves the choice to the home.

    tolerance, laboratory and client_order are files; client_order describes the client's order
    (`mimu-order/1`). calibrated_on: for a recording without a date of its own. as_found: the run
    (an id, or the path of a recording) of the unit before adjustment, whose results the certificate
    shows beside these. budget: whether the certificate prints the uncertainty budgets. invalid_run:
    whether to report an invalid run all the same. by: who drafts it; null means the operator in the
    laboratory's file.
    """

    tolerance: str | None = None
    laboratory: str | None = None
    client_order: str | None = None
    calibrated_on: date | None = None
    as_found: str | None = None
    budget: bool = False
    invalid_run: bool = False
    by: str | None = None


class CertifyOrder(CalibrateOrder, CertificateOptions):
    """The result, the verdict and the certificate of a run."""


class ProduceOrder(AcquireOrder, CertificateOptions):
    """A run from a station, and its certificate.

    number: of the production order in the catalogue's queue; null for one that was given directly.
    """

    number: str | None = None

    def certify(self, run: str) -> CertifyOrder:
        """The order of the certificate, once the run exists."""
        shared = CertificateOptions.model_fields
        return CertifyOrder(run=run, **{name: getattr(self, name) for name in shared})


class StepOrder(OrderModel):
    """A step that a person takes with a certificate (its number, or the key of its draft)."""

    certificate: str
    by: Person


class CheckOrder(StepOrder):
    """A draft was checked."""

    reason: str | None = None


class IssueOrder(StepOrder):
    """A checked certificate is issued, and gets its number."""

    reason: str | None = None


class WithdrawOrder(StepOrder):
    """An issued certificate is withdrawn."""

    why: str = Field(min_length=1)


class AmendOrder(StepOrder, CertificateOptions):
    """A draft that is to replace an issued certificate.

    run: on which it is based, by default that of the certificate. Options that are not given are
    taken from the certificate, limits from the home.
    """

    by: Person
    why: str = Field(min_length=1)
    run: str | None = None
