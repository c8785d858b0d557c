"""The results of the DCC."""

from schemas.calibration import Item
from schemas.certificate import Certificate
from tasks.certificate.dcc.xml import Element, dcc, named, si
from tasks.specifications.items import item_title
from tasks.words import message


def measurement_results(certificate: Certificate) -> Element:
    """Every item of the calibration."""
    calibration = certificate.calibration
    return dcc.measurementResults(
        dcc.measurementResult(
            named(message("certificate-title")),
            dcc.results(
                *(
                    dcc.result(named(item_title(name)), dcc.data(_elements(item)))
                    for name, item in calibration.items.items()
                )
            ),
        )
    )


def _elements(item: Item) -> Element:
    return dcc.list(
        *(
            dcc.quantity(si.real(si.label(element), si.value(repr(value)), si.unit(r"\one")))
            for element, value in item.value.items()
            if value is not None
        )
    )
