"""Commands about missing physics: `explain`, `next`, `simulate` and `review`."""

import sys

import typer

from flows import options
from schemas.base import Unusable
from tasks.words import say

app = typer.Typer()


@app.command(epilog="Example: mimucal explain r8b7e8cc74921 --out report")
def explain(
    runs: options.Runs,
    out: options.ReportFolder = None,
    calibration: options.Result = None,
    simulated: options.Simulated = None,
    as_json: options.Json = False,
) -> None:
    """Find where model and run differ, and which physics is missing.

    Several runs of one unit are analysed together, so that weak evidence accumulates.
    """
    from flows import run_orders
    from flows.carry_out import carry_out
    from schemas.orders import ExplainOrder

    order = ExplainOrder(
        run=runs[0],
        others=tuple(runs[1:]),
        out=str(out) if out else None,
        calibration=calibration,
        simulated=str(simulated) if simulated else None,
    )
    explained = carry_out(run_orders.explain, order, order.run)
    if as_json:
        print(explained.discrepancy.model_dump_json(indent=1))
        return
    from flows.print_discrepancy import print_discrepancy

    print_discrepancy(explained)


@app.command(name="next", epilog="Example: mimucal next r8b7e8cc74921 --minutes 15 --out next.json")
def next_recording(
    runs: options.Runs,
    effects: options.Effects = None,
    minutes: options.Minutes = 15.0,
    procedure: options.BaseProcedure = None,
    out: options.NewProcedure = None,
    station: options.AbleStation = None,
    as_json: options.Json = False,
) -> None:
    """Propose the shortest recording that decides what `explain` leaves open.

    Writes a procedure for `acquire --procedure`.
    """
    from flows import run_orders
    from flows.carry_out import carry_out
    from schemas.orders import NextOrder

    names = tuple(name.strip() for name in (effects or "").split(",") if name.strip())
    if effects is not None and not names:
        raise Unusable("--for is empty: name effects, or leave it out for what explain left open.")
    order = NextOrder(
        runs=tuple(runs),
        effects=names,
        minutes=minutes,
        base=procedure or None,
        out=str(out) if out else None,
        station=str(station) if station else None,
    )
    answer = carry_out(run_orders.next_recording, order, ", ".join(order.runs))
    if as_json:
        print(answer.model_dump_json(indent=1))
        return
    print(say(answer.statement))
    if answer.procedure:
        print(answer.procedure)


@app.command(epilog="Example: mimucal simulate r8b7e8cc74921 --out simulated")
def simulate(
    run: options.Run,
    out: options.NewFolder,
    calibration: options.OwnResult = None,
    as_json: options.Json = False,
) -> None:
    """Simulate the readings of a calibrated unit for the motion of a run.

    Writes a recording for `explain --simulated`.
    """
    from flows import run_orders
    from flows.carry_out import carry_out
    from schemas.orders import SimulateOrder

    order = SimulateOrder(run=run, out=str(out), calibration=calibration)
    simulation = carry_out(run_orders.simulate, order, order.run)
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


@app.command(epilog="Example: mimucal review --station ST-03 --since 2026-03-01")
def review(
    paths: options.Reviewed = None,
    station: options.StationId = None,
    model: options.Model = None,
    serial: options.Serial = None,
    since: options.Since = None,
    until: options.Until = None,
    out: options.ReviewFolder = None,
    as_json: options.Json = False,
) -> None:
    """Find effects that only many runs show together, what carries them, and since when."""
    from flows import run_orders
    from flows.carry_out import carry_out
    from schemas.orders import ReviewOrder, order_of

    order = order_of(
        ReviewOrder,
        paths=tuple(paths or ()),
        station=station,
        model=model,
        serial=serial,
        since=since.date() if since else None,
        until=until.date() if until else None,
        out=str(out) if out else None,
    )
    reviewed = carry_out(run_orders.review, order, "runs")
    if as_json:
        print(reviewed.review.model_dump_json(indent=1))
        return
    from flows.print_discrepancy import print_review

    print_review(reviewed)
