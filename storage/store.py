"""Everything that is kept, behind one door."""

from storage.certificates import (
    Due,
    Entry,
    certificate_of,
    certificates,
    due,
    reserve_number,
    save_certificate,
)
from storage.results import Result, results, save_result
from storage.runs import Run, find, keep, known, load, runs
from storage.sources import fingerprint, read

__all__ = [
    "Due",
    "Entry",
    "Result",
    "Run",
    "certificate_of",
    "certificates",
    "due",
    "find",
    "fingerprint",
    "keep",
    "known",
    "load",
    "read",
    "reserve_number",
    "results",
    "runs",
    "save_certificate",
    "save_result",
]
