"""A measurement standard from its own Digital Calibration Certificate (PTB DCC 3.x, D-SI).

Read are results with a list of nominal values (refType basic_nominalValue) and their errors
(basic_measurementError, indicated less actual) with expanded uncertainty: over a rate in rad/s or
°/s, over an angle in rad or °. Everything else of the document is left alone.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple

from lxml import etree
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.laboratory import LimitName, MeasurementStandard
from schemas.text import CONTRACTED, no_text
from storage.whole_files import text_bytes

NAMES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
NOMINAL = {"basic_nominalValue"}
ERROR = {"basic_measurementError", "basic_measurementError_error"}
PER_SECOND = r"\second\tothe{-1}"
ANGLES = {r"\degree": 1.0, r"\radian": math.degrees(1.0), r"\arcsecond": 1.0 / 3600.0}  # in °
RATES = {unit + PER_SECOND: factor for unit, factor in ANGLES.items()}  # in °/s
RATIOS = {r"\one": 1.0, r"\percent": 1e-2, r"\ppm": 1e-6}
DIGITS = 9  # significant, more than any certificate states


class _Number(NamedTuple):
    value: float
    unit: str
    U: float
    k: float


def read_standard(path: Path, deviation: Literal["corrected", "budgeted"]) -> MeasurementStandard:
    """The standard of a DCC: its names, numbers and day, and the errors that are stated of it.

    deviation: what is done with the errors. Where several results are over rate, or over angle, the
    name of each is that of its axis. Raises Unusable for what is no such document.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True)
    try:
        root = etree.fromstring(text_bytes(path), parser)
    except OSError as error:
        raise Unusable(f"{path} cannot be read ({error.strerror}); name another file.") from error
    except etree.XMLSyntaxError as error:
        raise Unusable(f"{path} is not XML ({error}); name the XML of a DCC.") from error
    if root.tag != f"{{{NAMES['dcc']}}}digitalCalibrationCertificate":
        raise Unusable(f"{path} is no digitalCalibrationCertificate; name the XML of a DCC.")
    item = "dcc:administrativeData/dcc:items/dcc:item"
    core = "dcc:administrativeData/dcc:coreData"
    try:
        stated = list(_errors(root))
        if not stated:
            raise ValueError(
                "no result has both basic_nominalValue (over rad/s, °/s, rad or °) and "
                "basic_measurementError"
            )
        content = f"{item}/dcc:name/dcc:content"
        names = [_text(root, f"{content}[@lang='{language}']") for language in CONTRACTED]
        names[0] = names[0] or _text(root, content)
        return MeasurementStandard.model_validate({
            **dict(zip(no_text("name"), names, strict=True)),
            "serial": _text(root, f"{item}/dcc:identifications/dcc:identification/dcc:value"),
            "accuracy": "",
            "certificate": _text(root, f"{core}/dcc:uniqueIdentifier"),
            "calibrated_on": _text(root, f"{core}/dcc:endPerformanceDate") or None,
            "functions": _functions(stated, deviation),
        })  # fmt: skip
    except ValidationError as fault:
        raise Unusable(f"{path}: {first_fault(fault)}; write that standard by hand.") from fault
    except ValueError as fault:
        raise Unusable(f"{path}: {fault}; write that standard by hand.") from fault


def _text(element: Any, path: str) -> str:
    return (element.findtext(path, default="", namespaces=NAMES) or "").strip()


def _functions(
    stated: list[tuple[LimitName, str, dict[str, float], float]], deviation: str
) -> dict[LimitName, Any]:
    """By property: its rows, those of each axis together; k, if it is one."""
    rows: dict[LimitName, dict[str, list[dict[str, float]]]] = {}
    factors = defaultdict(set)
    for name, axis, row, k in stated:
        rows.setdefault(name, {}).setdefault(axis, []).append(row)
        factors[name].add(k)
    functions: dict[LimitName, Any] = {}
    for name, of_axes in rows.items():
        if len(factors[name]) > 1:
            raise ValueError(f"the errors of {name} have more than one coverage factor")
        listed = [
            row | ({"axis": axis} if len(of_axes) > 1 else {})
            for axis, each in of_axes.items()
            for row in _both_directions(each)
        ]
        functions[name] = {"deviation": deviation, "k": factors[name].pop(), "rows": listed}
    return functions


def _both_directions(rows: list[dict[str, float]]) -> Iterator[dict[str, float]]:
    """Rows rising; of two at one place, their mean with a U that holds both."""
    by_place = defaultdict(list)
    for row in rows:
        by_place[row["at"]].append(row)
    for at, each in sorted(by_place.items()):
        lowest, highest = (edge(row["deviation"] for row in each) for edge in (min, max))
        yield {
            "at": at,
            "deviation": _short(0.5 * (lowest + highest)),
            "U": _short(max(row["U"] for row in each) + 0.5 * (highest - lowest)),
        }


def _errors(root: Any) -> Iterator[tuple[LimitName, str, dict[str, float], float]]:
    """Property, axis (the result's name), row and k of every stated error."""
    for result in root.iterfind(".//dcc:result", NAMES):
        nominal, errors = _numbers(result, NOMINAL), _numbers(result, ERROR)
        over_rate = nominal and all(each.unit in RATES for each in nominal)
        if not errors or not (over_rate or all(each.unit in ANGLES for each in nominal)):
            continue
        axis = _text(result, "dcc:name/dcc:content[@lang='en']")
        axis = axis or _text(result, "dcc:name/dcc:content")
        if len(nominal) != len(errors):
            raise ValueError(
                f"result {axis!r} has {len(nominal)} nominal values and {len(errors)} errors"
            )
        for at, error in zip(nominal, errors, strict=True):
            if not math.isfinite(error.U):
                raise ValueError(f"result {axis!r} has an error without an expanded uncertainty")
            if over_rate:
                yield "rate", axis, _rate_row(at, error), error.k
            else:
                to_rad = math.radians(_factor(error, ANGLES))
                row = {"deviation": error.value * to_rad, "U": error.U * to_rad}
                yield "position", axis, {"at": _short(at.value * ANGLES[at.unit])} | row, error.k


def _rate_row(at: _Number, error: _Number) -> dict[str, float]:
    """Relative to the actual rate, whether the document has a rate or a ratio."""
    indicated = at.value * RATES[at.unit]
    row = {"at": _short(abs(indicated))}
    if error.unit in RATIOS:
        factor = RATIOS[error.unit]
        return row | {"deviation": error.value * factor, "U": error.U * factor}
    factor = _factor(error, RATES)
    actual = indicated - error.value * factor
    if not actual:
        raise ValueError("an error of rate is as large as the rate")
    return row | {"deviation": error.value * factor / actual, "U": error.U * factor / abs(actual)}


def _factor(number: _Number, units: dict[str, float]) -> float:
    if number.unit not in units:
        raise ValueError(f"an error is in {number.unit}, not in one of {', '.join(units)}")
    return units[number.unit]


def _numbers(result: Any, types: set[str]) -> list[_Number]:
    """The numbers of the quantities of some types, in order; of a hybrid those of its first unit.

    U is NaN where none is stated.
    """
    found: list[_Number] = []
    for quantity in result.iterfind(".//dcc:quantity", NAMES):
        if not types & set((quantity.get("refType") or "").split()):
            continue
        of_one = quantity.find(".//si:real", NAMES)
        listed = quantity.find(".//si:realListXMLList", NAMES)
        if listed is not None:
            found += _list(listed)
        elif of_one is not None:
            found.append(_one(of_one))
    return found


def _one(real: Any) -> _Number:
    U = _text(real, ".//si:valueExpandedMU") or _text(real, ".//si:expandedUnc/si:uncertainty")
    k = _text(real, ".//si:coverageFactor")
    return _Number(
        _number(_text(real, "si:value")), _text(real, "si:unit"), _number(U or "nan"),
        _number(k or "2"),
    )  # fmt: skip


def _list(listed: Any) -> list[_Number]:
    """The numbers of a list; unit, U and k stand once for all, or once for each."""
    values = _text(listed, "si:valueXMLList").split()
    U = _text(listed, ".//si:valueExpandedMUXMLList") or _text(listed, ".//si:uncertaintyXMLList")
    columns = [_text(listed, "si:unitXMLList"), U or "nan"]
    columns.append(_text(listed, ".//si:coverageFactorXMLList") or "2")
    split = [column.split() for column in columns]
    if any(len(each) not in (1, len(values)) for each in split):
        raise ValueError(f"a list of {len(values)} values has other numbers of units, U or k")
    units, expanded, factors = (each * len(values) if len(each) == 1 else each for each in split)
    return [
        _Number(_number(value), unit, _number(of_value), _number(k))
        for value, unit, of_value, k in zip(values, units, expanded, factors, strict=True)
    ]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{text!r} stands where a number should") from None


def _short(number: float) -> float:
    return float(f"{number:.{DIGITS}g}")
