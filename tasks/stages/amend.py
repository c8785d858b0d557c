"""What an amendment takes over from the certificate it replaces."""

from dataclasses import dataclass, replace

from schemas.base import Unusable
from schemas.certificate import Certificate, Order, Replaced
from schemas.certificate_orders import AmendOrder
from schemas.orders import Estimation
from schemas.tolerance import Tolerance
from storage.catalogue.certificates import entry_of
from storage.home import Home
from tasks.stages.certificate_inputs import CertificateInputs, read_inputs
from tasks.stages.estimate import how_made
from tasks.stages.issue import check_issued


@dataclass(frozen=True)
class Amendment:
    """How a run is certified again. run, as_found: ids of runs, or paths of recordings."""

    run: str
    as_found: str | None
    how: Estimation
    inputs: CertificateInputs
    replaces: Replaced


def amendment(order: AmendOrder, home: Home) -> Amendment:
    """The certificate that is to come in the place of an issued one; Unusable for any other.

    Method, terms and way to the uncertainties are those of before. Of another run neither the day
    nor the run as found is taken over.
    """
    entry = entry_of(order.certificate, home)
    old = check_issued(entry, home)
    before = old.calibration.run
    same_run = order.run in (None, before)
    found = old.as_found.calibration.run if old.as_found and same_run else None
    return Amendment(
        run=order.run or before,
        as_found=order.as_found or found,
        how=how_made(old.calibration),
        inputs=_inputs(order, old, same_run),
        replaces=Replaced(number=old.number, issued_on=old.issued_on, why=order.why),
    )


def _inputs(order: AmendOrder, old: Certificate, same_run: bool) -> CertificateInputs:
    given = read_inputs(order)
    client_order = given.order or old.order
    return replace(
        given,
        tolerance=given.tolerance or _limits(old, client_order),
        laboratory=given.laboratory or old.laboratory,
        order=client_order,
        calibrated_on=given.calibrated_on or (old.calibrated_on if same_run else None),
        budget=given.budget or old.budgets,
        invalid_run=given.invalid_run or old.calibration.validity.verdict == "invalid",
        operator=given.operator or (old.operator if same_run else None),
        report=given.report or old.report,
    )


def _limits(old: Certificate, client_order: Order | None) -> Tolerance | None:
    """The limits of the verdict; Unusable where a record of an earlier version lacks them."""
    decided = old.decision.limits and (client_order is None or client_order.conformity)
    if old.tolerance is None and decided:
        raise Unusable(
            f"the record of {old.number} is of an earlier version and does not hold the limits of "
            "its verdict: give them with --tolerance"
        )
    return old.tolerance
