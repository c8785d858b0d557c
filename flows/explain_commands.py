"""The commands about what the model leaves out: `explain`, and `simulate` to hold against it."""

import sys

import typer

from flows import options

app = typer.Typer()


@app.command()
def explain(
    run: options.Run,
    out: options.ReportFolder = None,
    calibration: options.Result = None,
    simulated: options.Simulated = None,
    as_json: options.Json = False,
) -> None:
    """Find where model and run differ, and which physics is missing."""
    from flows.carry_out import carry_out
    from schemas.orders import ExplainOrder

    order = ExplainOrder(
        run=run,
        out=str(out) if out else None,
        calibration=calibration,
        simulated=str(simulated) if simulated else None,
    )
    explained = carry_out("explain", order, order.run)
    if as_json:
        print(explained.discrepancy.model_dump_json(indent=1))
        return
    from flows.print_explanation import print_explanation

    print_explanation(explained)


@app.command()
def simulate(
    run: options.Run,
    out: options.NewFolder,
    calibration: options.OwnResult = None,
    as_json: options.Json = False,
) -> None:
    """Write what a unit with a calibration would have read on a run's motion.

    The recording is one that `explain --simulated` reads.
    """
    from flows.carry_out import carry_out
    from schemas.orders import SimulateOrder

    order = SimulateOrder(run=run, out=str(out), calibration=calibration)
    simulation = carry_out("simulate", order, order.run)
    if as_json:
        from flows.printing import print_json

        print_json(
            {
                "format": "mimu-simulate/1",
                "path": str(simulation.folder),
                "rows": simulation.rows,
                "rows_left_out": simulation.rows_left_out,
                "assumed_ideal": list(simulation.assumed),
            }
        )
        return
    print(simulation.folder)
    if simulation.rows_left_out:
        print(
            f"{simulation.rows_left_out} rows left out: how it moved is not known", file=sys.stderr
        )
    if simulation.assumed:
        print(f"taken as ideal, not calibrated: {', '.join(simulation.assumed)}", file=sys.stderr)
