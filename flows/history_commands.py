"""Commands over the history of a store: `reprocess`, `table`, `impact`; and `dashboard`."""

from contextlib import suppress

import typer

from flows import options
from schemas.base import BrokenOff
from storage.home import home
from storage.whole_files import report_folder

app = typer.Typer()


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
    from flows import print_history, run_orders
    from flows.carry_out import as_flow_run
    from schemas.orders import ReprocessOrder, order_of
    from storage.catalogue.connection import Busy
    from storage.catalogue.selection import check_known

    order = order_of(
        ReprocessOrder,
        since=since.date() if since else None,
        until=until.date() if until else None,
        model=model,
        serial=serial,
        station=station,
        procedure=procedure,
        equipment=equipment,
        code_version=code_version,
        engine=engine,
        scheduler=scheduler,
        workers=workers,
        out=out,
        dry_run=dry_run,
    )
    if dry_run:
        from tasks.stages.reprocess import plan

        planned = plan(order, run_orders.home_of(order))
        if as_json:
            print(planned.model_dump_json(indent=1))
        else:
            print_history.print_plan(planned)
        return
    try:
        # An order that cannot be carried out is refused before Prefect is started for it.
        with suppress(Busy):  # the flow waits for the catalogue
            check_known(order, run_orders.home_of(order))
        report_folder(order.out)
        report = as_flow_run(run_orders.reprocess, order)
    except KeyboardInterrupt as stop:
        raise BrokenOff(
            "stopped by the operator; what is done is kept, and the same command continues with "
            "the rest"
        ) from stop
    if as_json:
        print(report.model_dump_json(indent=1))
    else:
        print_history.print_report(report, out)


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
    from flows.tables import print_table, write_table

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
    from flows.print_history import print_impact
    from schemas.orders import Selection, order_of
    from storage.catalogue.selection import impact_of

    first, last = since.date() if since else None, until.date() if until else None
    selection = order_of(Selection, equipment=equipment, since=first, until=last)
    found = impact_of(selection, home())
    if as_json:
        print(found.model_dump_json(indent=1))
    else:
        print_impact(found)


@app.command(epilog="Example: mimucal dashboard --port 8765")
def dashboard(host: options.Host = "127.0.0.1", port: options.PagesPort = 8765) -> None:
    """Serve the operations pages until Ctrl-C.

    Line, runs, units, quality, mismatch and due dates, in Chinese and English.
    """
    from flows.pages.serve import serve

    serve(home(), host, port)
