"""Orders of certificates: drafted, checked, issued, amended, withdrawn (see `orders`)."""

from datetime import date
from typing import Annotated

from pydantic import Field

from schemas.certificate import Order
from schemas.orders import AcquireOrder, CalibrateOrder, OrderModel
from schemas.signature import Signature

Person = Annotated[str, Field(min_length=1, pattern=r"\S")]


class CertificateOptions(OrderModel):
    """Inputs of a certificate beside the result; null leaves the choice to the home.

    tolerance, laboratory and client_order are files; client_order, the client's order
    (`mimu-order/1`), may also stand here itself. calibrated_on: for a recording without a date of
    its own. as_found: the run (an id, or the path of a recording) of the unit before adjustment,
    whose results the certificate shows beside these. budget: whether the certificate prints the
    uncertainty budgets. invalid_run: whether to report an invalid run all the same. by: who drafts
    it; null means the operator in the laboratory's file. signature: what a flow wants to see of an
    order that names a person. operator: who carried out the measurement, for a recording that does
    not say it. report: the agreement with the client by which this is a report of less than a
    certificate states (ISO/IEC 17025:2017, 7.8.1.3); null for a certificate.
    """

    tolerance: str | None = None
    laboratory: str | None = None
    client_order: str | Order | None = None
    calibrated_on: date | None = None
    as_found: str | None = None
    budget: bool = False
    invalid_run: bool = False
    by: str | None = None
    operator: str | None = None
    report: str | None = Field(default=None, min_length=1, pattern=r"\S")
    signature: Signature | None = None


class CertifyOrder(CalibrateOrder, CertificateOptions):
    """The result, the verdict and the certificate of a run."""


class ProduceOrder(AcquireOrder, CertificateOptions):
    """A run from a station, and its certificate.

    number: of the production order in the catalogue, which then says what is measured for whom;
    null makes an order of its own, as for a schedule.
    """

    number: str | None = None

    def certify(self, run: str) -> CertifyOrder:
        """The order of the certificate, once the run exists; it is signed for its own flow."""
        shared = CertificateOptions.model_fields.keys() - {"signature"}
        return CertifyOrder(run=run, **{name: getattr(self, name) for name in shared})


class StepOrder(OrderModel):
    """A step that a person takes with a certificate (its number, or the key of its draft).

    signature: what a flow wants to see of it.
    """

    certificate: str
    by: Person
    signature: Signature | None = None


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
    taken from the certificate, its limits among them.
    """

    by: Person
    why: str = Field(min_length=1)
    run: str | None = None
