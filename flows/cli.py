"""The command `mimucal`. Each command imports what it needs when it runs, to start at once."""

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from schemas.base import Unusable

app = typer.Typer(
    name="mimucal",
    help="Calibrate inertial units on turntables: from the station to the certificate.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
station = typer.Typer(help="Stations.", no_args_is_help=True)
app.add_typer(station, name="station")

Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")]
RunArgument = Annotated[str, typer.Argument(metavar="RUN", help="Run id, or path to a recording.")]
ToleranceOption = Annotated[
    str | None, typer.Option("--tolerance", help="Limits of the product model (TOML or JSON).")
]
LaboratoryOption = Annotated[
    str | None, typer.Option("--laboratory", help="The laboratory (TOML or JSON).")
]
OrderOption = Annotated[
    str | None, typer.Option("--order", help="The client's order (TOML or JSON).")
]
MethodOption = Annotated[str, typer.Option("--method", help="jjf2003")]


def main() -> None:
    """Run the command line. Exit 2 with one sentence for unusable input, 1 for own failures."""
    try:
        app()
    except Unusable as fault:
        _say_and_leave(str(fault), 2)
    except KeyboardInterrupt:
        _say_and_leave("stopped by the operator", 1)
    except Exception as failure:
        if os.environ.get("MIMUCAL_DEBUG"):
            raise
        _say_and_leave(
            f"mimucal itself failed ({type(failure).__name__}: {failure}); MIMUCAL_DEBUG=1 shows "
            "where",
            1,
        )


def _say_and_leave(sentence: str, code: int) -> None:
    print(" ".join(sentence.split()), file=sys.stderr)
    raise SystemExit(code)


@app.command()
def demo(
    speed: Annotated[float, typer.Option(help="Station seconds in a wall second.")] = 60.0,
    seed: Annotated[int, typer.Option(help="Which virtual unit.")] = 1,
    as_json: Json = False,
) -> None:
    """The main job, whole, on this machine: virtual station to certificate and reminder."""
    from flows.demo import run_demo

    run_demo(speed=speed, seed=seed, as_json=as_json)


@app.command(name="import")
def import_(
    paths: Annotated[list[Path], typer.Argument(metavar="PATH...", help="Folders, MCAP files.")],
    manifest: Annotated[
        Path | None, typer.Option(help="manifest.json for an MCAP file that has none.")
    ] = None,
    salvage: Annotated[
        bool, typer.Option("--salvage", help="Take what is whole of a cut-off MCAP file.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Take recordings into the store; the same content twice is one run."""
    from flows.progress import working
    from storage.home import home
    from tasks.stages.record import take_in

    taken = []
    for path in paths:
        with working(f"importing {path.name}"):
            run, is_new = take_in(path, home(), manifest=manifest, salvage=salvage)
        taken.append({"run": run.id, "recording_id": run.recording_id, "new": is_new})
        if not as_json:
            print(run.id if is_new else f"{run.id} (already there)")
    if as_json:
        _json({"format": "mimu-import/1", "runs": taken})


@app.command()
def calibrate(run: RunArgument, method: MethodOption = "jjf2003", as_json: Json = False) -> None:
    """Estimate every item the run allows, and say which it cannot give and why."""
    calibration = _ordered("calibrate", reference=run, method=method)
    if as_json:
        print(calibration.model_dump_json(indent=1))
        return
    from flows.printing import print_calibration

    print_calibration(calibration)


@app.command()
def certify(
    run: RunArgument,
    method: MethodOption = "jjf2003",
    tolerance: ToleranceOption = None,
    laboratory: LaboratoryOption = None,
    order: OrderOption = None,
    as_json: Json = False,
) -> None:
    """Hold a run's results against the limits and make the certificate."""
    issued = _ordered(
        "certify",
        reference=run,
        method=method,
        tolerance=tolerance,
        laboratory=laboratory,
        order=order,
    )
    _print_issued(issued, as_json)


@app.command()
def acquire(
    station_file: Annotated[str, typer.Argument(metavar="STATION", help="Station file.")],
    procedure: Annotated[str, typer.Option(help="Name of a procedure, or a file.")] = "jjf2003",
    as_json: Json = False,
) -> None:
    """A run on a station, real or virtual; what was recorded survives whatever happens."""
    from flows.papers import read_procedure
    from storage.settings import read_station

    read_station(Path(station_file))  # a bad file is refused before a flow starts
    read_procedure(procedure)
    run, acquired = _as_flow("acquire", station=station_file, procedure=procedure)
    if as_json:
        warnings = [remark.en for remark in acquired.warnings]
        _json(
            {
                "format": "mimu-acquire/1",
                "run": run.id,
                "recording_id": run.recording_id,
                "lost_samples": acquired.lost_samples,
                "bad_frames": acquired.bad_frames,
                "warnings": warnings,
            }
        )
        return
    print(run.id)
    for remark in acquired.warnings:
        print(remark.en, file=sys.stderr)


@app.command()
def runs(as_json: Json = False) -> None:
    """What is in the store."""
    from flows.printing import print_rows
    from storage import store
    from storage.home import home

    found = store.runs(home())
    if as_json:
        _json({"format": "mimu-runs/1", "runs": [run.model_dump(mode="json") for run in found]})
        return
    print_rows(
        "Runs",
        ("run", "recording", "unit", "standard", "taken in", "seconds"),
        [
            (r.id, r.recording_id, f"{r.manufacturer} {r.model} {r.serial}", r.standard,
             str(r.taken_in_at)[:19], f"{r.seconds:.0f}")
            for r in found
        ],
    )  # fmt: skip


@app.command()
def show(run: RunArgument, as_json: Json = False) -> None:
    """One run: what it is, its segments, its results, its certificates."""
    from flows.show import show_run

    show_run(run, as_json)


@app.command()
def verify(
    path: Annotated[Path | None, typer.Argument(help="A recording; default: the store.")] = None,
    as_json: Json = False,
) -> None:
    """Integrity of everything stored, or of one recording; exit 1 if there are faults."""
    from flows.progress import counting
    from storage import verify as integrity
    from storage.home import home

    if path is not None:
        checked, faults = 1, integrity.verify_path(path)
    else:
        with counting("verifying") as report:
            checked, faults = integrity.verify(home(), report)
    if as_json:
        listed = [{"what": fault.what, "why": fault.why} for fault in faults]
        _json({"format": "mimu-verify/1", "checked": checked, "faults": listed})
    else:
        print(f"{checked} checked, {len(faults)} faults")
        for fault in faults:
            print(f"{fault.what}: {fault.why}")
    raise SystemExit(1 if faults else 0)


@app.command()
def remind(
    within: Annotated[int, typer.Option(help="Days ahead.")] = 30, as_json: Json = False
) -> None:
    """The units whose recalibration is due."""
    from storage.home import home
    from tasks.stages.remind import due_within

    due = due_within(home(), within)
    if as_json:
        listed = [
            {"unit": d.unit, "certificate": d.certificate, "due": d.due.isoformat(), "sent": []}
            for d in due
        ]
        _json({"format": "mimu-reminders/1", "due": listed})
        return
    from flows.printing import print_rows

    rows = [(d.unit, d.certificate, d.due.isoformat()) for d in due]
    print_rows(f"Recalibration due within {within} days", ("unit", "certificate", "due"), rows)


@station.command()
def serve(
    host: str = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Modbus/TCP port; the unit is on the next.")] = 5020,
    speed: Annotated[float, typer.Option(help="Station seconds in a wall second.")] = 1.0,
    fault: Annotated[list[str] | None, typer.Option(help="NAME[@SECONDS], repeatable.")] = None,
    seed: Annotated[int, typer.Option(help="Which virtual unit.")] = 1,
    station_file: Annotated[
        Path, typer.Option(help="Where the file for `mimucal acquire` is written.")
    ] = Path("station.json"),
    truth: Annotated[Path | None, typer.Option(help="Where the unit's truth is written.")] = None,
) -> None:
    """A virtual three-axis station as a server, until it is stopped."""
    from flows.station import serve_station

    serve_station(host, port, speed, tuple(fault or ()), seed, station_file, truth)


def _ordered(name: str, **parameters: Any) -> Any:
    """Carry out an order: as a flow run where a Prefect server is named, else right here."""
    from flows.orders import server_named
    from tasks.stages.estimate import check_method

    check_method(parameters["method"])
    if server_named():
        return _as_flow(name, **parameters)
    from flows import here
    from flows.progress import working

    with working(f"{name} {parameters['reference']}"):
        return getattr(here, name)(**parameters)


def _as_flow(name: str, **parameters: Any) -> Any:
    from flows.orders import prepare
    from storage.home import home

    prepare(home())
    from flows import line

    return line.run_now(getattr(line, name), **parameters)


def _print_issued(issued: Any, as_json: bool) -> None:
    certificate = issued.certificate
    if as_json:
        _json(
            {
                "format": "mimu-certificate/1",
                "number": certificate.number,
                "verdict": certificate.decision.verdict,
                "state": certificate.state,
                "pdf": str(issued.pdf),
                "dcc": None,
                "record": str(issued.record),
                "run": certificate.calibration.run,
                "due": certificate.due.isoformat(),
                "reasons": list(certificate.decision.reasons),
            }
        )
        return
    from flows.printing import print_verdict

    print_verdict(issued)


def _json(document: Any) -> None:
    from flows.printing import print_json

    print_json(document)


if __name__ == "__main__":
    main()
