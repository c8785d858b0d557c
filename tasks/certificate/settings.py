"""The settings of a calibration with their printed names and units."""

from collections.abc import Iterator
from dataclasses import dataclass

from schemas.calibration import Calibration
from tasks.certificate.equipment import limits_of, size, stated_by
from tasks.certificate.fields import NOT_GIVEN, first_known, given, literal, slug
from tasks.uncertainty.equipment import TAKEN_TO_BE_MET
from tasks.words import Message, Sayable, message
from tasks.words.quantities import quantity_text
from tasks.words.rounding import as_given
from tasks.words.typography import clause

UNITS = {"gravity_m_s2": "m/s2", "latitude_deg": "deg", "mount": "deg"}
LIMIT = "limit of "
RECOMMENDED_BY = "limits"  # the document that recommends those of the others
LIMIT_UNITS = {"rate": "1", "ripple": "1", "gravity": "m/s2"}  # of the others: rad
BY_EXAMPLE = " (the example's)"
OF_UNIT = " (the unit's)"


@dataclass(frozen=True)
class Setting:
    """One setting: its name, its value as printed; number and unit where it is a number."""

    name: Sayable
    value: Sayable
    number: float | None = None
    unit: str = "1"

    @property
    def printed(self) -> Message:
        """Name and value."""
        return message("certificate-setting-with", name=self.name, value=self.value)


def settings(calibration: Calibration) -> Iterator[Setting]:
    """Every setting that the calibration was made with.

    Without the document that recommends limits, if every limit in the budgets is another's.
    """
    limits = limits_of(calibration)
    none_recommended = bool(limits) and not any(each.source in TAKEN_TO_BE_MET for each in limits)
    for name, value in calibration.settings.items():
        if not (name == RECOMMENDED_BY and none_recommended):
            yield setting(name, value)


def setting(name: str, value: float | str | None) -> Setting:
    """A setting as results carry it."""
    if not isinstance(value, int | float):
        return Setting(_name(name), _printed_value(name, value))
    unit = UNITS.get(name, "1")
    return Setting(_name(name), given(quantity_text(as_given(value), unit)), value, unit)


def _name(name: str) -> Sayable:
    if name.startswith(LIMIT):
        limit = first_known(f"uncertainty-{name.removeprefix(LIMIT)}")
        return message("certificate-setting-limit", limit=limit or given(name))
    return first_known(f"certificate-setting.{slug(name)}") or given(name)


def _printed_value(name: str, value: str | None) -> Sayable:
    if value is None:
        return NOT_GIVEN
    for ending, origin in ((BY_EXAMPLE, "by-example"), (OF_UNIT, "of-unit")):
        if value.endswith(ending):
            number = literal(value.removesuffix(ending))
            return message(f"certificate-setting-{origin}", number=number)
    if name.startswith(LIMIT):
        limit = name.removeprefix(LIMIT)
        number, _, source = value.partition(" ")
        shown = size(float(number), LIMIT_UNITS.get(limit, "rad"), limit == "latitude")
        by = stated_by(source.removeprefix("(").removesuffix(")"))
        return message("certificate-setting-stated", half_width=shown, source=by)
    worded = {"uncertainty": "kind", "axes": "axes-setting"}.get(name)
    kind = first_known(f"certificate-{worded}.{slug(value)}") if worded else None
    return kind or (clause(value) if value.startswith("JJF") else given(value))
