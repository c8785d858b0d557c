"""The report: sentences in every language, charts, a page, and the prediction as a file."""

from tasks.explain.report.discrepancy import discrepancy_of
from tasks.explain.report.page import pictures_of, report_html, write_report

__all__ = ["discrepancy_of", "pictures_of", "report_html", "write_report"]
