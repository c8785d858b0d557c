"""The report: sentences in every language, pictures, a page to read, the prediction as a file."""

from tasks.explain.report.discrepancy import discrepancy_of
from tasks.explain.report.page import write_report

__all__ = ["discrepancy_of", "write_report"]
