"""Serves stored files: the PDF of a certificate, the report of an explained run."""

from flask import Blueprint, Response

from flows.pages.run.data import pdf_of
from schemas.base import Unusable
from storage.catalogue.discrepancies import report_of
from storage.catalogue.run_index import find
from storage.home import Home


def files(home: Home) -> Blueprint:
    """GET /certificate/NUMBER.pdf and /explained/RUN.html."""
    made = Blueprint("files", __name__)

    @made.get("/certificate/<number>.pdf")
    def certificate(number: str) -> Response:
        try:
            name, content = pdf_of(number, home)
        except Unusable as error:
            return Response(str(error), 404, mimetype="text/plain")
        disposition = {"Content-Disposition": f'inline; filename="{name}"'}
        return Response(content, mimetype="application/pdf", headers=disposition)

    @made.get("/explained/<run>.html")
    def explained(run: str) -> Response:
        try:
            report = report_of(find(run, home), home)
        except Unusable as error:
            return Response(str(error), 404, mimetype="text/plain")
        if report is None:
            return Response(f"Run {run} was not explained yet.", 404, mimetype="text/plain")
        return Response(report, mimetype="text/html")

    return made
