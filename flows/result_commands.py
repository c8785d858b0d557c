"""Commands about results: `explain`, `next`, `simulate`, `review`, and the history of runs."""

import sys
from contextlib import suppress

import typer

from flows import options
from schemas.base import BrokenOff, Unusable
from storage.home import home
from storage.whole_files import report_folder
from tasks.words import say

# Commands about missing physics: `explain`, `next`, `simulate` and `review`.

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
    from flows import execute
    from flows.carry_out import carry_out
    from schemas.orders import ExplainOrder

    order = ExplainOrder(
        run=runs[0],
        others=tuple(runs[1:]),
        out=str(out) if out else None,
        calibration=calibration,
        simulated=str(simulated) if simulated else None,
    )
    explained = carry_out(execute.explain, order, order.run)
    if as_json:
        print(explained.discrepancy.model_dump_json(indent=1))
        return
    from flows.shown_results import print_discrepancy

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
    from flows import execute
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
    answer = carry_out(execute.next_recording, order, ", ".join(order.runs))
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
    given = options.fields(locals())
    from flows import execute
    from flows.carry_out import carry_out
    from schemas.orders import SimulateOrder

    order = SimulateOrder(**given)
    simulation = carry_out(execute.simulate, order, order.run)
    if as_json:
        from flows.terminal import print_json

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
    given = options.fields(locals())
    from flows import execute
    from flows.carry_out import carry_out
    from schemas.orders import ReviewOrder, order_of

    order = order_of(ReviewOrder, **given)
    reviewed = carry_out(execute.review, order, "runs")
    if as_json:
        print(reviewed.review.model_dump_json(indent=1))
        return
    from flows.shown_results import print_review

    print_review(reviewed)


# Commands over the history of a store: `reprocess`, `table`, `impact`; and `dashboard`.


@app.command(epilog="Example: mimucal reprocess --since 2026-03-01 --dry-run")
def reprocess(
    since: options.Since = None,
    until: options.Until = None,
    model: options.Model = None,
    serial: options.Serial = None,
    station: options.StationId = None,
    procedure: options.OfProcedure = None,
    equipment: options.OfEquipment = None,
    code_version: options.CodeVersion = None,
    engine: options.Engine = "local",
    scheduler: options.Scheduler = None,
    workers: options.Workers = None,
    out: options.ChangesFolder = None,
    dry_run: options.WouldBeDone = False,
    as_json: options.Json = False,
) -> None:
    """Recompute the latest results of past runs with the current code and report what changed.

    New results are stored beside the old ones. After an interruption, the same command continues.
    """
    given = options.fields(locals())
    from flows import execute, shown_results
    from flows.carry_out import as_flow_run
    from schemas.orders import ReprocessOrder, order_of
    from storage.catalogue.database import Busy
    from storage.catalogue.selection import check_known

    order = order_of(ReprocessOrder, **given)
    if dry_run:
        from tasks.stages.reprocess import plan

        planned = plan(order, execute.home_of(order))
        if as_json:
            print(planned.model_dump_json(indent=1))
        else:
            shown_results.print_plan(planned)
        return
    try:
        # An order that cannot be carried out is refused before Prefect is started for it.
        with suppress(Busy):  # the flow waits for the catalogue
            check_known(order, execute.home_of(order))
        report_folder(order.out)
        report = as_flow_run(execute.reprocess, order)
    except KeyboardInterrupt as stop:
        raise BrokenOff(
            "stopped by the operator; what is done is kept, and the same command continues with "
            "the rest"
        ) from stop
    if as_json:
        print(report.model_dump_json(indent=1))
    else:
        shown_results.print_report(report, out)


@app.command(epilog="Example: mimucal table results --as parquet --out results.parquet")
def table(
    what: options.What,
    form: options.TableForm = "csv",
    out: options.TableFile = None,
    as_json: options.Json = False,
) -> None:
    """Export the store as tables: runs, results, segments or certificates.

    Written to standard output or to a file.
    """
    from flows.terminal import print_table, write_table

    (print_table if as_json else write_table)(what, form, out)


@app.command(epilog="Example: mimucal impact TT-3000-07 --since 2026-03-01 --until 2026-05-31")
def impact(
    equipment: options.Equipment,
    since: options.Since = None,
    until: options.Until = None,
    as_json: options.Json = False,
) -> None:
    """List the runs, results and certificates that used a measurement standard or a station.

    Between two days of recording, both included.
    """
    given = options.fields(locals())
    from flows.shown_results import print_impact
    from schemas.orders import Selection, order_of
    from storage.catalogue.selection import impact_of

    found = impact_of(order_of(Selection, **given), home())
    if as_json:
        print(found.model_dump_json(indent=1))
    else:
        print_impact(found)


@app.command(epilog="Example: mimucal dashboard --port 8765")
def dashboard(host: options.Host = "127.0.0.1", port: options.PagesPort = 8765) -> None:
    """Serve the operations pages until Ctrl-C.

    Line, runs, units, quality, mismatch and due dates, in Chinese and English.
    """
    from flows.pages.app import serve

    serve(home(), host, port)
