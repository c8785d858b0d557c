"""The Digital Calibration Certificate (PTB DCC 3.3.0 with D-SI 2.2.1) of a certificate."""

from tasks.certificate.dcc.document import dcc_of, record_bytes

__all__ = ["dcc_of", "record_bytes"]
