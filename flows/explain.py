"""The commands about what the model leaves out: `explain`, and `simulate` to hold against it."""

import sys

import typer

from flows import options
from flows.ordering import ordered

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
    explained = ordered(
        "explain",
        reference=run,
        out=str(out) if out else None,
        calibration=calibration,
        simulated=str(simulated) if simulated else None,
    )
    if as_json:
        print(explained.discrepancy.model_dump_json(indent=1))
        return
    from flows.print_explained import print_explained

    print_explained(explained)


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
    made = ordered("simulate", reference=run, out=str(out), calibration=calibration)
    if as_json:
        from flows.printing import print_json

        print_json(
            {
                "format": "mimu-simulate/1",
                "path": str(made.folder),
                "rows": made.rows,
                "rows_left_out": made.rows_left_out,
                "assumed_ideal": list(made.assumed),
            }
        )
        return
    print(made.folder)
    if made.rows_left_out:
        print(f"{made.rows_left_out} rows left out: how it moved is not known", file=sys.stderr)
    if made.assumed:
        print(f"taken as ideal, not calibrated: {', '.join(made.assumed)}", file=sys.stderr)
