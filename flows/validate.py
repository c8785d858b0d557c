"""`mimucal validate`: checks the methods by simulation and keeps the validation record."""

from functools import partial
from pathlib import Path

from flows.terminal import counting, print_rows, stdout
from schemas.base import Unusable
from schemas.calibration import ValidationRecord
from storage.home import home
from storage.settings import VALIDATION
from storage.whole_files import writing_in_home
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.register import SPECIFICATIONS
from tasks.validation.coverage import MIN_UNITS, Calibrate
from tasks.validation.make import make_record
from tasks.validation.record import validation_html
from tasks.version import code_version


def run_validate(units: int, seed: int, out: Path | None, as_json: bool) -> None:
    """Make the validation record of all methods, and its page, in the home or at `out`.

    Raises Unusable for fewer units than a record in the home needs.
    """
    if out is None and units < MIN_UNITS:
        raise Unusable(
            f"--units {units}: a study of fewer than {MIN_UNITS} units shows nothing and would "
            "replace the record in the home; say with --out where it is to be written"
        )
    record_file = out or home().path / VALIDATION
    if record_file.suffix != ".json":
        raise Unusable(f"--out {record_file}: the record is a .json file; name it so")
    with counting(f"validate {len(SPECIFICATIONS)} methods") as report:
        methods: dict[str, Calibrate] = {
            name: partial(calibrate, spec) for name, spec in SPECIFICATIONS.items()
        }
        record = make_record(methods, units, seed, code_version(), report)
    text = record.model_dump_json(indent=1) + "\n"
    with writing_in_home(record_file):
        record_file.write_text(text, encoding="utf-8")
        record_file.with_suffix(".html").write_text(validation_html(record), encoding="utf-8")
    if as_json:
        print(text, end="")
        return
    _print(record, record_file)


def _print(record: ValidationRecord, record_file: Path) -> None:
    rows = [
        (
            method,
            name,
            f"{100 * item.coverage.inside_95:.1f} %" if item.coverage else "-",
            f"{item.coverage.rms_z:.2f}" if item.coverage else "-",
            "yes" if item.valid else ", ".join(k for k, c in item.checks.items() if not c.passed),
        )
        for method, validation in record.methods.items()
        for name, item in validation.items.items()
    ]
    print_rows("Validation", ("method", "item", "inside 95 %", "rms z", "valid"), rows)
    console = stdout(markup=False)
    console.print(f"record {record_file}")
    console.print(f"page   {record_file.with_suffix('.html')}")
