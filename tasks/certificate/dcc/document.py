"""The complete DCC document, made from the certificate alone."""

from schemas.certificate import Certificate
from tasks.certificate.dcc.administration import administration
from tasks.certificate.dcc.results import measurement_results
from tasks.certificate.dcc.statements import statements
from tasks.certificate.dcc.xml import canonical, dcc
from tasks.conformity.capabilities import certificate_as_stated

VERSION = "3.3.0"


def record_of(certificate: Certificate) -> bytes:
    """The record as it is stored, attached to the DCC, and identified by its SHA-256 in the QR
    code.
    """
    return certificate.model_dump_json(indent=1).encode()


def dcc_of(certificate: Certificate) -> bytes:
    """The DCC without a signature, in canonical form (C14N 1.0, UTF-8)."""
    record = record_of(certificate)
    stated = certificate_as_stated(certificate)
    return canonical(
        dcc.digitalCalibrationCertificate(
            administration(stated, statements(certificate, record)),
            measurement_results(stated),
            schemaVersion=VERSION,
        )
    )
