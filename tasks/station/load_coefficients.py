"""Writes the coefficients of a correction into the unit, by the lines of its description."""

import re
from functools import reduce
from operator import xor
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.calibration import CorrectedUnit, Correction
from schemas.recording import Unit
from schemas.station import StationFile
from schemas.unit_link import CoefficientLines, UnitLink
from tasks.station.drivers.backend import ANSWER_S, asked, unit_port


def load_correction(correction: Correction, station: StationFile) -> tuple[CorrectedUnit, int]:
    """Write a correction into the station's unit of that serial; the unit, and how many lines.

    Raises Unusable where the correction is of no unit of the station, its description has no
    lines, they name what the correction has not, and where the unit does not acknowledge one.
    """
    unit, link = _unit_of(correction, station)
    if link.load is None:
        raise Unusable(
            f"unit_link of unit {unit.serial} in the station file has no load: describe there the "
            "lines by which the unit receives its coefficients"
        )
    lines = [_line(template, correction, link.load) for template in link.load.lines]
    _write(lines, link, link.load)
    return unit, len(lines)


def _unit_of(correction: Correction, station: StationFile) -> tuple[CorrectedUnit, UnitLink]:
    wanted = correction.unit
    for each in station.per_unit():
        if wanted is not None and _is_the_same(wanted, each.unit):
            return wanted, each.unit_link
    whose = f"{wanted.model} {wanted.serial}" if wanted else "a unit that is not known"
    there = ", ".join(f"{each.unit.model} {each.unit.serial}" for each in station.per_unit())
    raise Unusable(
        f"the result is of {whose}, but station {station.station.id} has {there}: give the result "
        "of that unit, or correct unit in the station file"
    )


def _is_the_same(one: CorrectedUnit, other: Unit) -> bool:
    names = ("manufacturer", "model", "serial")
    return all(getattr(one, name) == getattr(other, name) for name in names)


def _line(template: str, correction: Correction, load: CoefficientLines) -> bytes:
    values: dict[str, Any] = {
        name: (np.array(coefficient.value) / load.scale.get(name, 1.0)).tolist()
        for name, coefficient in correction.coefficients.items()
    }
    try:
        text = template.format(**values)
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise Unusable(
            f"the line “{template}” of unit_link.load cannot be written ({error}): the "
            f"coefficients are {', '.join(values)}, each of 3 or 3 × 3 elements counted from 0"
        ) from error
    if load.check == "xor8":
        text += f"*{reduce(xor, text.lstrip('$!').encode(), 0):02X}"
    return (text + load.terminator).encode()


def _write(lines: list[bytes], link: UnitLink, load: CoefficientLines) -> None:
    if link.url.startswith(("udp://", "file://")):
        raise Unusable(f"unit_link.url {link.url} can only be read from: give a serial line")
    try:
        acknowledgement = load.acknowledge.encode()
        pattern = re.compile(re.escape(acknowledgement))
        with unit_port(link) as port:
            for number, line in enumerate(lines):
                port.reset_input_buffer()
                if asked(port, line, pattern, len(acknowledgement), ANSWER_S) is None:
                    raise Unusable(
                        f"the unit on {link.url} did not acknowledge “{line.decode().strip()}” "
                        f"with “{load.acknowledge}” within {ANSWER_S:g} s (lines acknowledged "
                        f"before it: {number}): see its manual, then load again"
                    )
    except (OSError, ValueError) as error:  # pyserial's own is an OSError
        raise Unusable(
            f"the unit's line {link.url} cannot be written to ({error}): check the cable and "
            "unit_link.url of the station file"
        ) from error
