"""The PDF of a certificate, as it is kept."""

from flask import Blueprint, Response

from flows.pages.run_data import pdf_of
from schemas.base import Unusable
from storage.home import Home


def files(home: Home) -> Blueprint:
    """GET /certificate/NUMBER.pdf."""
    made = Blueprint("files", __name__)

    @made.get("/certificate/<number>.pdf")
    def certificate(number: str) -> Response:
        try:
            name, content = pdf_of(number, home)
        except Unusable as error:
            return Response(str(error), 404, mimetype="text/plain")
        disposition = {"Content-Disposition": f'inline; filename="{name}"'}
        return Response(content, mimetype="application/pdf", headers=disposition)

    return made
