"""The results: every item of the specification by element, as found and as left."""

from collections.abc import Iterator
from itertools import chain

from schemas.calibration import Calibration, Elements, Information, Item
from schemas.certificate import Certificate
from schemas.decision import Decision
from schemas.text import text_of
from tasks.certificate.dcc.conditions import influences, methods
from tasks.certificate.dcc.conformity import conformity
from tasks.certificate.dcc.covariance import covariance_result
from tasks.certificate.dcc.curves import curve_results
from tasks.certificate.dcc.equipment import equipment
from tasks.certificate.dcc.quantities import coverage, quantity, ref_type, without_number
from tasks.certificate.dcc.software import software
from tasks.certificate.dcc.units import dsi_unit, gravity_of
from tasks.certificate.dcc.xml import Element, dcc, described, named
from tasks.certificate.fields import given, quoted
from tasks.certificate.information import WITHOUT_U
from tasks.certificate.results import Group, sections
from tasks.specifications.items import ITEMS
from tasks.specifications.register import SPECIFICATIONS
from tasks.specifications.specification import Specification
from tasks.words import message, statement
from tasks.words.rounding import stated


def measurement_results(certificate: Certificate) -> Element:
    """As left, or the only ones there are; as found; what is shown beside, undecided."""
    found = certificate.as_found
    calibration, decision = certificate.calibration, certificate.decision
    after = "afterAdjustment" if found else None
    parts = [_results("dcc-results", certificate, calibration, decision, after)]
    if found:
        before = (found.calibration, found.decision, "beforeAdjustment")
        parts.append(_results("dcc-as-found", certificate, *before))
    if calibration.information:
        shown = (
            _information(certificate, name, each) for name, each in calibration.information.items()
        )
        parts.append(_result_part("dcc-information", certificate, calibration, after, shown))
    if certificate.curves:
        curves = curve_results(certificate)
        parts.append(_result_part("dcc-curves", certificate, calibration, after, curves))
    return dcc.measurementResults(*equipment(certificate), *parts)


def _results(
    title: str, certificate: Certificate, calibration: Calibration, decision: Decision,
    status: str | None,
) -> Element:  # fmt: skip
    """Every item of the specification's appendix, also those without a value; their covariance."""
    specification = SPECIFICATIONS[calibration.method]
    known = list(chain.from_iterable(section.items for section in specification.layout))
    names = known + [name for name in calibration.items if name not in known]
    printed = sections(calibration, decision, specification)
    groups = chain.from_iterable(section.groups for section in printed)
    items = (
        _item(name, group, certificate, calibration, decision)
        for name, group in zip(names, groups, strict=True)
    )
    together = covariance_result(certificate, calibration)
    more = () if together is None else (together,)
    return _result_part(title, certificate, calibration, status, chain(items, more))


def _result_part(
    title: str, certificate: Certificate, calibration: Calibration, status: str | None,
    results: Iterator[Element],
) -> Element:  # fmt: skip
    return dcc.measurementResult(
        named(message(title)),
        dcc.usedMethods(*methods(calibration)),
        dcc.usedSoftware(software(calibration.code_version)),
        dcc.influenceConditions(*influences(certificate, calibration, status)),
        dcc.results(*results),
    )


def _item(
    name: str, group: Group, certificate: Certificate, calibration: Calibration, decision: Decision
) -> Element:
    item = calibration.items.get(name)
    quantities = _quantities(name, item, group, certificate, decision) if item else []
    return dcc.result(
        named(group.title),
        described(group.clause or "", group.kind or "", *group.sentences),
        dcc.data(dcc.list(*quantities) if quantities else without_number(group.title)),
        refType=ref_type(name),
    )


def _quantities(
    name: str, item: Item, group: Group, certificate: Certificate, decision: Decision
) -> list[Element]:
    """Every element of each value that is printed, with what was decided on it."""
    unit = dsi_unit(item.unit, gravity_of(certificate))
    specification = SPECIFICATIONS[certificate.calibration.method]
    made = []
    for column, (which, values, U) in zip(
        group.columns, _values(name, item, specification), strict=False
    ):
        for element, value in values.items():
            number, expanded = stated(value, U.get(element), item.k)
            of = ITEMS[name].element_title(element) if name in ITEMS else given(element)
            title = message("dcc-element", element=of, column=column)
            decided = [
                conformity(limit, unit)
                for limit in decision.limits
                if (limit.item, limit.element, limit.applied_to) == (name, element, which)
            ]
            label = ".".join((name, element) if which == "value" else (name, which, element))
            more = [dcc.measurementMetaData(*decided)] if decided else []
            budget = item.budgets.get(element)
            at = coverage(item.k, budget.coverage_probability if budget else None)
            made.append(quantity(title, label, number, unit, expanded, at, more))
    return made


def _values(
    name: str, item: Item, specification: Specification
) -> Iterator[tuple[str, Elements, Elements]]:
    """The value by the clause, and the one that is printed beside it; each with its U."""
    yield "value", item.value, item.U
    second = ITEMS[name].second_value if name in ITEMS else None
    beside = getattr(item, second) if second and name not in specification.printed_once else None
    if second and beside:
        yield second, beside, item.U_without_earth_rotation or item.U


def _information(certificate: Certificate, name: str, shown: Information) -> Element:
    """Something that the data show beside the items; nothing is decided on it."""
    title = quoted(text_of(shown, "title") or statement(name))
    unit = dsi_unit(shown.unit, gravity_of(certificate))
    U, made = shown.U or {}, []
    for element, value in shown.value.items():
        number, expanded = stated(value, U.get(element), shown.k, WITHOUT_U)
        of_element = message("dcc-element", element=title, column=given(element))
        at = coverage(shown.k)
        made.append(quantity(of_element, f"{name}.{element}", number, unit, expanded, at))
    return dcc.result(
        named(title),
        described(quoted(shown)),
        dcc.data(dcc.list(*made) if made else without_number(title)),
        refType=f"{ref_type('information')} {ref_type(name)}",
    )
