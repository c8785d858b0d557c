"""Commands for the life of a certificate: check, issue, amend, withdraw, and the audit trail."""

import sys
from collections.abc import Mapping
from typing import Any

import typer

from flows import options
from schemas.base import Unusable

app = typer.Typer()


@app.command(epilog='Example: mimucal check draft-r8b7e8cc --by "Li Na"')
def check(
    certificate: options.Certificate,
    by: options.By = None,
    reason: options.Reason = None,
    as_json: options.Json = False,
) -> None:
    """Record that a person has checked the draft of a certificate."""
    _step("check", locals())


@app.command(epilog='Example: mimucal issue draft-r8b7e8cc --by "Chen Jie"')
def issue(
    certificate: options.Certificate,
    by: options.By = None,
    reason: options.Reason = None,
    as_json: options.Json = False,
) -> None:
    """Issue a checked certificate: it receives its number and is frozen."""
    _step("issue", locals())


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
    report: options.Report = None,
    operator: options.CarriedOutBy = None,
    as_json: options.Json = False,
) -> None:
    """Draft a certificate that replaces an issued one, from the current result of its run.

    Limits, order, laboratory and the rest are those of the old one where they are not given here,
    and the draft prints everything that is different.
    The draft is checked and issued like any other; on issue, the old one is marked as amended.
    """
    _step("amend", locals())


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
    _step("withdraw", locals())


@app.command(epilog="Example: mimucal trail --as csv")
def trail(form: options.TrailForm = "table", as_json: options.Json = False) -> None:
    """Print the audit trail: who did what, and when.

    `verify` checks that it is complete and unaltered.
    """
    from flows.shown_results import print_trail

    print_trail("json" if as_json else form)


def _step(step: str, chosen: Mapping[str, Any]) -> None:
    """Takes a step of a certificate: `execute` has it by its name, and its order is called so."""
    from flows import execute
    from flows.carry_out import carry_out
    from flows.shown_results import print_certificate
    from schemas import orders

    given = options.fields(chosen)
    if not given.get("by", "").strip():
        raise Unusable(
            f"Say who does it: mimucal {step} {given['certificate']} --by NAME, or let "
            "MIMUCAL_USER name the person."
        )
    order = orders.order_of(getattr(orders, f"{step.capitalize()}Order"), **given)
    published = carry_out(getattr(execute, step), order, order.certificate)
    print_certificate(published, chosen["as_json"])


# Commands that take a result to where the unit is used: `export` and `apply`.


@app.command(epilog="Example: mimucal export r8b7e8cc74921 --as kalibr")
def export(
    result: options.Calibrated,
    form: options.As,
    as_json: options.Json = False,
) -> None:
    """Print the correction given by a result, for firmware and other software.

    Includes its formulas, units, uncertainties and an example. As evidence: the means,
    combinations, noise and errors from which anyone can reproduce the result and its U.
    """
    from flows.execute import home_of
    from flows.terminal import print_json
    from schemas.orders import ExportOrder, order_of
    from tasks.stages.correct import export_correction
    from tasks.stages.estimate import export_evidence

    order = order_of(ExportOrder, calibration=result, **{"as": form})
    if order.form == "evidence":
        print(export_evidence(order, home_of(order)), end="")
        return
    correction, text = export_correction(order, home_of(order))
    if as_json and form != "json":
        print_json({"format": "mimu-export/1", "as": form, "text": text})
    else:
        print(text, end="")
    _say_what_is_left(correction.assumed_ideal, correction.left_in)


@app.command(epilog="Example: mimucal apply r8b7e8cc74921 r8b7e8cc74921 --out corrected")
def apply(
    result: options.Calibrated,
    recording: options.ToCorrect,
    out: options.CorrectedFolder,
    with_u: options.WithU = False,
    as_json: options.Json = False,
) -> None:
    """Write a recording corrected for its unit's errors, with the uncertainty of the correction.

    The output folder is a recording that `calibrate` can read. The uncertainty is that by the
    calibration, common to all readings; their own noise is not in it.
    """
    from flows import execute
    from flows.carry_out import carry_out
    from flows.terminal import print_json
    from schemas.orders import ApplyOrder
    from tasks.words.numbers import USUAL_K

    order = ApplyOrder(calibration=result, run=recording, out=str(out), with_u=with_u)
    corrected = carry_out(execute.apply, order, order.run)
    if as_json:
        print_json(
            {
                "format": "mimu-apply/1",
                "path": str(corrected.folder),
                "rows": corrected.rows,
                "rows_left_out": corrected.rows_left_out,
                "assumed_ideal": list(corrected.assumed),
                "left_in": list(corrected.left_in),
                "u_rms": corrected.u_rms,
                "k": USUAL_K,
            }
        )
        return
    print(corrected.folder)
    for name, u in corrected.u_rms.items():
        unit = "rad/s" if name.startswith("gyro") else "m/s2"
        U = f"{USUAL_K * u:.2g} {unit} (k = {USUAL_K:g}, rms over the rows)"
        print(f"{name}: U of the correction = {U}", file=sys.stderr)
    if corrected.rows_left_out:
        left_out = corrected.rows_left_out
        print(f"{left_out} rows left out: gyro or accelerometer alone", file=sys.stderr)
    _say_what_is_left(corrected.assumed, corrected.left_in)


def _say_what_is_left(assumed: tuple[str, ...], left_in: tuple[str, ...]) -> None:
    if assumed:
        print(f"taken as ideal, not calibrated: {', '.join(assumed)}", file=sys.stderr)
    if left_in:
        print(f"not corrected: {', '.join(left_in)}", file=sys.stderr)
