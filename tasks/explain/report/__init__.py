"""The report: sentences in both languages, pictures, a page to read, the prediction as a file."""

from tasks.explain.report.page import write_report
from tasks.explain.report.statements import said

__all__ = ["said", "write_report"]
