"""The command `mimucal`. Each command imports what it needs only when it runs, to start quickly."""

import atexit
import errno
import gc
import os
import sys
from typing import Annotated

import typer
from pydantic import ValidationError
from typer.exceptions import TyperException

from flows import (
    certificate_commands,
    import_commands,
    operating_commands,
    options,
    order_commands,
    register_commands,
    result_commands,
    station_commands,
    store_commands,
)
from flows.logs import set_up
from flows.signals import end_as_ctrl_c
from schemas.base import BrokenOff, Unusable
from storage.home import environment
from tasks.version import code_version

GC_THRESHOLD = 300_000  # new objects between two collections; few commands make as many
INTERRUPTED = 130  # exit code of typer for Ctrl-C
LONGEST = 1200  # characters of a sentence; the middle of a longer one is cut out
ENDS = 300
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
INVALID = 3  # a run that was acquired and kept, but is invalid

app = typer.Typer(
    name="mimucal",
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode=None,
)
app.add_typer(certificate_commands.app)
app.add_typer(result_commands.app)
app.add_typer(import_commands.app)
app.add_typer(store_commands.app)
app.add_typer(operating_commands.app)
app.add_typer(register_commands.app, name="equipment")
app.add_typer(station_commands.app, name="station")
app.add_typer(order_commands.app, name="order")
app.add_typer(register_commands.users, name="user")


def _collect_rarely() -> None:
    """Saves a sixth of `mimucal runs` (0.3 s of 2.1 s): imported modules are not garbage, and at
    the end the system frees everything anyway.
    """
    gc.set_threshold(GC_THRESHOLD)
    atexit.register(gc.freeze)


def main() -> None:
    """Run the command line.

    Exits with 2 and one sentence for unusable input, with 1 for internal errors and interruptions.
    """
    end_as_ctrl_c()
    _collect_rarely()
    # Before numpy is imported: on matrices this small a second thread only occupies a core.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        set_up()
        _check_text(sys.argv[1:])
        code = app(sys.argv[1:] or ["--help"], standalone_mode=False)
    except TyperException as fault:
        _say_and_leave(f"{_fault_of(fault)}. See `mimucal --help`.", 2)
    except Unusable as fault:
        _say_and_leave(str(fault), 2)
    except BrokenOff as end:
        _say_and_leave(str(end), 1)
    except OSError as fault:
        if fault.errno not in NO_ROOM:
            _fail(fault)
        where = fault.filename or "the output"
        _say_and_leave(
            f"{where} cannot be written ({fault.strerror}); make room or give rights.", 2
        )
    except Exception as failure:
        _fail(failure)
    if code == INTERRUPTED:
        _say_and_leave("stopped by the operator", 1)
    raise SystemExit(code)


def _fault_of(fault: TyperException) -> str:
    """The fault in the arguments, with the value that was given."""
    text = fault.format_message().replace("Value error, ", "").rstrip(".")
    if not isinstance(fault.__cause__, ValidationError):
        return text
    given = fault.__cause__.errors()[0]["input"]
    return text.replace("Input should", f"{given!r} should")


def _fail(failure: Exception) -> None:
    if environment().debug:
        raise failure
    _say_and_leave(
        f"mimucal itself failed ({type(failure).__name__}: {failure}); MIMUCAL_DEBUG=1 shows where",
        1,
    )


def _check_text(arguments: list[str]) -> None:
    """Raises Unusable for an argument that cannot be printed on a page or in JSON."""
    for argument in arguments:
        if not argument.isascii() and any("\ud800" <= sign <= "\udfff" for sign in argument):
            raise Unusable(f"the argument {argument!a} is not UTF-8; give the file another name.")


def _say_and_leave(sentence: str, code: int) -> None:
    plain = " ".join(sentence.split())
    if len(plain) > LONGEST:
        plain = f"{plain[: LONGEST - ENDS]} … {plain[-ENDS:]}"
    print(plain, file=sys.stderr)
    raise SystemExit(code)


@app.callback(invoke_without_command=True)
def about(
    version: Annotated[
        bool, typer.Option("--version", help="Name, version and digest of the code.")
    ] = False,
) -> None:
    """Calibrate inertial units on turntables: from the station to the certificate."""
    if version:
        print(f"mimucal {code_version()}")
        raise typer.Exit


@app.command(epilog="Example: mimucal demo --procedure jjf1536")
def demo(
    procedure: options.Procedure = "jjf2003",
    speed: options.DemoSpeed = None,
    seed: options.Seed = 1,
    as_json: options.Json = False,
) -> None:
    """Run the complete workflow on this machine.

    From a virtual station to the certificate and the reminder.
    """
    from flows.demo import run_demo

    run_demo(procedure=procedure, speed=speed, seed=seed, as_json=as_json)


@app.command(epilog="Example: mimucal calibrate r8b7e8cc74921 --method joint")
def calibrate(
    run: options.Run,
    method: options.Method = None,
    uncertainty: options.Uncertainty = "gum",
    terms: options.Terms = None,
    as_json: options.Json = False,
) -> None:
    """Estimate every item that the run allows.

    States which items could not be determined, and why.
    """
    given = options.fields(locals())
    from flows import execute
    from flows.carry_out import carry_out
    from schemas.orders import CalibrateOrder, order_of

    order = order_of(CalibrateOrder, **given)
    calibration = carry_out(execute.calibrate, order, run)
    if as_json:
        print(calibration.model_dump_json(indent=1))
        return
    from flows.shown_results import print_calibration

    print_calibration(calibration)


@app.command(epilog="Example: mimucal certify r8b7e8cc74921 --tolerance tolerance.toml")
def certify(
    run: options.Run,
    method: options.Method = None,
    uncertainty: options.Uncertainty = "gum",
    tolerance: options.Tolerance = None,
    laboratory: options.Laboratory = None,
    order: options.Order = None,
    calibrated_on: options.CalibratedOn = None,
    as_found: options.AsFound = None,
    budget: options.Budget = False,
    invalid_run: options.InvalidRun = False,
    report: options.Report = None,
    terms: options.Terms = None,
    operator: options.CarriedOutBy = None,
    by: options.Operator = None,
    as_json: options.Json = False,
) -> None:
    """Assess a run against its limits and draft its certificate.

    The draft replaces an earlier one of the same run. An invalid run is refused.
    """
    given = options.fields(locals())
    from flows import execute
    from flows.carry_out import carry_out
    from flows.shown_results import print_certificate
    from schemas.orders import CertifyOrder, order_of

    ordered = order_of(CertifyOrder, **given)
    print_certificate(carry_out(execute.certify, ordered, run), as_json)


@app.command(epilog="Example: mimucal acquire station.json --dry-run")
def acquire(
    station_file: options.Station,
    procedure: options.Procedure = "jjf2003",
    resume: options.Resume = False,
    dry_run: options.DryRun = False,
    by: options.OperatedBy = None,
    as_json: options.Json = False,
) -> None:
    """Run a procedure on a station, real or virtual.

    The recording says who carried it out, which the certificate prints.
    Recorded data are kept whatever happens. Ctrl-Z pauses before the next segment and continues
    when pressed again; Ctrl-C stops the run, and --resume continues it later.
    Exits with 3 if the run was kept but is invalid, and with 1 if one of several units was
    abandoned; the runs of the others are kept.
    """
    from flows import execute
    from flows.carry_out import as_flow_run
    from flows.shown_results import print_acquired, print_dry_run
    from flows.terminal import ask_for_operator
    from schemas.orders import AcquireOrder

    order = AcquireOrder(
        station=station_file, procedure=procedure, attended=not as_json, resume=resume, by=by
    )
    if dry_run:
        execute.check_acquisition(order)
        print_dry_run(execute.procedure_of(order), as_json)
        return
    if by is None and order.attended:
        order = order.model_copy(update={"by": ask_for_operator()})
    execute.check_acquisition(order)
    execute.release_station(order)
    acquired = as_flow_run(execute.acquire, order)
    is_sound = print_acquired(acquired, execute.home_of(order), as_json)
    if acquired.given_up:
        raise BrokenOff("; ".join(map(str, acquired.given_up)))
    if not is_sound:
        raise typer.Exit(INVALID)


if __name__ == "__main__":
    main()
