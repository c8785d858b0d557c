"""The calibrated object: its condition, its configuration, and whether it was adjusted.

ISO/IEC 17025:2017, 7.8.2.1 g), 7.8.4.1 d) and 7.8.5.
"""

from collections.abc import Iterator

from schemas.certificate import Certificate
from schemas.text import text_of
from tasks.certificate.fields import Field, field, given
from tasks.words import Sayable, message
from tasks.words.rounding import as_given

NUMBERS = ("rate_range_deg_s", "accel_range_g", "output_rate_hz", "bandwidth_hz")


def calibrated_object(certificate: Certificate) -> tuple[Field, ...]:
    """What is known of the unit as it was calibrated; condition and range also where nobody says.

    A certificate without results as found is of a unit that was not adjusted.
    """
    configuration = certificate.configuration
    adjusted = "no" if certificate.as_found is None else "yes"
    return (
        field("condition", given(text_of(configuration, "condition"))),
        *_configuration(certificate),
        field("adjustment", message(f"certificate-adjusted.{adjusted}")),
        field("sampling", message("certificate-sampling")),
    )


def _configuration(certificate: Certificate) -> Iterator[Field]:
    configuration = certificate.configuration
    for name in NUMBERS:
        value: float | None = getattr(configuration, name)
        if value is not None:
            yield field(_label(name), _quantity(name, value))
        elif name == "rate_range_deg_s":
            yield field(_label(name), given(None))
    if configuration.firmware:
        yield field("firmware", given(configuration.firmware))


def _label(name: str) -> str:
    return name.removesuffix("_deg_s").removesuffix("_g").removesuffix("_hz").replace("_", "-")


def _quantity(name: str, value: float) -> Sayable:
    """A range counts on either side of zero."""
    if name.endswith("_hz"):
        return given(f"{as_given(value)} Hz")
    return given(f"±{as_given(value)} {'°/s' if name.endswith('_deg_s') else 'g'}")
