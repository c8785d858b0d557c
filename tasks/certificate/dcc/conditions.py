"""Measurement conditions: methods and their settings, air, gravity and latitude of the site."""

from collections.abc import Iterator
from decimal import Decimal

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from tasks.certificate.dcc.quantities import plain_quantity, text_quantity, without_number
from tasks.certificate.dcc.units import UNITS, DsiUnit
from tasks.certificate.dcc.xml import Element, dcc, described, named, plain
from tasks.certificate.fields import given
from tasks.certificate.settings import Setting, settings
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Sayable, message
from tasks.words.rounding import as_given

UNCERTAINTY = "JJF 1059.1-2012"


def methods(calibration: Calibration) -> Iterator[Element]:
    """The specification and the settings with which it was followed; the uncertainty."""
    specification = SPECIFICATIONS[calibration.method]
    quantities = [_quantity(setting) for setting in settings(calibration)]
    yield dcc.usedMethod(
        named(message(f"certificate-method.{calibration.method}")),
        described(given(calibration.procedure)),
        plain("norm", specification.standard),
        *([dcc.usedMethodQuantities(*quantities)] if quantities else []),
    )
    yield dcc.usedMethod(
        named(message("certificate-label-uncertainty")),
        plain("norm", UNCERTAINTY),
        refType="basic_methodMeasurementUncertainty",
    )


def _quantity(setting: Setting) -> Element:
    tag = "usedMethodQuantity"
    if setting.number is None:
        return text_quantity(setting.name, setting.value, tag)
    return plain_quantity(setting.name, Decimal(repr(setting.number)), UNITS[setting.unit], tag)


def influences(
    certificate: Certificate, calibration: Calibration, status: str | None
) -> Iterator[Element]:
    """Air and place; status: before or after an adjustment, where there was one."""
    air, station = calibration.environment, certificate.manifest.station
    temperature, humidity = (
        tuple(Decimal(f"{edge:.1f}") for edge in edges or ())
        for edges in (air.temperature_degc, air.humidity_percent)
    )
    gravity, latitude = (
        () if number is None else (Decimal(as_given(number).replace("−", "-")),)
        for number in (station.gravity_m_s2, station.latitude_deg)
    )
    for name, numbers, unit, kind in (
        ("certificate-environment.temperature", temperature, "degC", "basic_temperature"),
        ("certificate-environment.humidity", humidity, "%", "basic_humidityRelative"),
        ("certificate-field.gravity", gravity, "m/s2", "basic_gravity"),
        ("certificate-field.latitude", latitude, "deg", "basic_latitude"),
    ):
        yield _influence(message(name), numbers, UNITS[unit], kind, status)


def _influence(
    name: Sayable, numbers: tuple[Decimal, ...], unit: DsiUnit, kind: str, status: str | None
) -> Element:
    """One number, the smallest and the largest of it, or that it is not known."""
    edges = ("",) if len(numbers) == 1 else ("Min", "Max")
    quantities = [
        plain_quantity(name, number, unit, refType=kind + edge)
        for number, edge in zip(numbers, edges, strict=False)
    ]
    return dcc.influenceCondition(
        named(name),
        *([dcc.status(status)] if status else []),
        dcc.data(*quantities or [without_number(name)]),
        refType=kind,
    )
