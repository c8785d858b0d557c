"""A unit of which its client is reminded."""

from datetime import date

from schemas.base import Frozen


class DueUnit(Frozen):
    """A unit due for recalibration, with the issued certificate that agreed the interval.

    key: the unit's number in the catalogue. client, laboratory: the name in English and in Chinese.
    """

    unit: str
    key: int
    model: str
    certificate: str
    issued_on: date
    due: date
    client: tuple[str, str]
    laboratory: tuple[str, str]
