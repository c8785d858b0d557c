"""Commands that take a result to where the unit is used: `export` and `apply`."""

import sys

import typer

from flows import correction_options, options

app = typer.Typer()


@app.command(epilog="Example: mimucal export r8b7e8cc74921 --as kalibr")
def export(
    result: options.Calibrated,
    form: correction_options.As,
    as_json: options.Json = False,
) -> None:
    """Print the correction given by a result, for firmware and other software.

    Includes its formulas, units, uncertainties and an example. As evidence: the means,
    combinations, noise and errors from which anyone can reproduce the result and its U.
    """
    from flows.printing import print_json
    from flows.run_orders import home_of
    from schemas.orders import ExportOrder, order_of
    from tasks.stages.correct import export_correction
    from tasks.stages.evidence import export_evidence

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
    recording: correction_options.ToCorrect,
    out: correction_options.CorrectedFolder,
    with_u: correction_options.WithU = False,
    as_json: options.Json = False,
) -> None:
    """Write a recording corrected for its unit's errors, with the uncertainty of the correction.

    The output folder is a recording that `calibrate` can read. The uncertainty is that by the
    calibration, common to all readings; their own noise is not in it.
    """
    from flows import run_orders
    from flows.carry_out import carry_out
    from flows.printing import print_json
    from schemas.orders import ApplyOrder
    from tasks.words.rounding import USUAL_K

    order = ApplyOrder(calibration=result, run=recording, out=str(out), with_u=with_u)
    corrected = carry_out(run_orders.apply, order, order.run)
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
