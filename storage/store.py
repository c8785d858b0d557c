"""Everything that is kept, behind one door."""

from storage.certificates import (
    Due,
    Entry,
    certificate_of,
    certificates,
    due,
    reminded,
    reserve_number,
    save_certificate,
    save_reminder,
)
from storage.results import Result, latest_result, results, save_result
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
    "latest_result",
    "load",
    "read",
    "reminded",
    "reserve_number",
    "results",
    "runs",
    "save_certificate",
    "save_reminder",
    "save_result",
]
