"""Commands for the life of a certificate: check, issue, amend, withdraw, and the audit trail."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import typer

from flows import certificate_options, options
from schemas.base import Unusable

if TYPE_CHECKING:
    from tasks.stages.published import Published

app = typer.Typer()


@app.command(epilog='Example: mimucal check draft-r8b7e8cc --by "Li Na"')
def check(
    certificate: options.Certificate,
    by: options.By = None,
    reason: options.Reason = None,
    as_json: options.Json = False,
) -> None:
    """Record that a person has checked the draft of a certificate."""
    from flows import run_orders
    from schemas.certificate_orders import CheckOrder

    _step(run_orders.check, CheckOrder, as_json, certificate=certificate, by=by, reason=reason)


@app.command(epilog='Example: mimucal issue draft-r8b7e8cc --by "Chen Jie"')
def issue(
    certificate: options.Certificate,
    by: options.By = None,
    reason: options.Reason = None,
    as_json: options.Json = False,
) -> None:
    """Issue a checked certificate: it receives its number and is frozen."""
    from flows import run_orders
    from schemas.certificate_orders import IssueOrder

    _step(run_orders.issue, IssueOrder, as_json, certificate=certificate, by=by, reason=reason)


@app.command(epilog='Example: mimucal amend MC-2026-0001 --why "client renamed"')
def amend(
    certificate: options.Certificate,
    why: options.Why,
    by: options.By = None,
    run: options.AmendedRun = None,
    tolerance: options.Tolerance = None,
    laboratory: options.Laboratory = None,
    order: options.Order = None,
    calibrated_on: options.CalibratedOn = None,
    as_found: options.AsFound = None,
    budget: options.Budget = False,
    invalid_run: options.InvalidRun = False,
    report: certificate_options.Report = None,
    operator: certificate_options.CarriedOutBy = None,
    as_json: options.Json = False,
) -> None:
    """Draft a certificate that replaces an issued one, from the current result of its run.

    Limits, order, laboratory and the rest are those of the old one where they are not given here,
    and the draft prints everything that is different.
    The draft is checked and issued like any other; on issue, the old one is marked as amended.
    """
    from flows import run_orders
    from schemas.certificate_orders import AmendOrder

    _step(
        run_orders.amend,
        AmendOrder,
        as_json,
        certificate=certificate,
        by=by,
        why=why,
        run=run,
        tolerance=tolerance,
        laboratory=laboratory,
        client_order=order,
        calibrated_on=calibrated_on.date() if calibrated_on else None,
        as_found=as_found,
        budget=budget,
        invalid_run=invalid_run,
        report=report,
        operator=operator,
    )


@app.command(epilog='Example: mimucal withdraw MC-2026-0001 --why "wrong unit"')
def withdraw(
    certificate: options.Certificate,
    why: options.Why,
    by: options.By = None,
    as_json: options.Json = False,
) -> None:
    """Withdraw an issued certificate.

    Its files remain unchanged.
    """
    from flows import run_orders
    from schemas.certificate_orders import WithdrawOrder

    _step(run_orders.withdraw, WithdrawOrder, as_json, certificate=certificate, by=by, why=why)


@app.command(epilog="Example: mimucal trail --as csv")
def trail(form: options.TrailForm = "table", as_json: options.Json = False) -> None:
    """Print the audit trail: who did what, and when.

    `verify` checks that it is complete and unaltered.
    """
    from flows.print_certificate import print_trail

    print_trail("json" if as_json else form)


def _step(work: Callable[[Any], "Published"], kind: Any, as_json: bool, **fields: Any) -> None:
    from flows.carry_out import carry_out
    from flows.print_certificate import print_certificate
    from schemas.orders import order_of

    if not (fields["by"] or "").strip():
        raise Unusable(
            f"Say who does it: mimucal {work.__name__} {fields['certificate']} --by NAME, or let "
            "MIMUCAL_USER name the person."
        )
    print_certificate(carry_out(work, order_of(kind, **fields), fields["certificate"]), as_json)
