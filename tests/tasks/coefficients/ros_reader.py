"""A parameter file as ROS 2 reads it: every event of its YAML, by the rules of ROS's own parser.

That is stricter than YAML: no aliases, no list in a list, one type in a list, and a plain scalar
is what strtol and strtod make of it. Source: ros2/rcl, rcl_yaml_param_parser/src/parse.c
(parse_file_events, parse_key, parse_value, get_value).
"""

import re
from collections.abc import Iterator

import yaml
from yaml.events import (
    AliasEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
)

PARAMETERS = "ros__parameters"
TRUE = {"Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
FALSE = {"N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
INTEGER = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|[0-9]+)")  # strtol, base 0
SMALLEST = 2.2250738585072014e-308  # below it, strtod sets ERANGE and the parser takes text
QUOTED = ("'", '"')

Scalar = bool | int | float | str
Values = dict[str, dict[str, Scalar | list[Scalar]]]


class RosRefusesError(Exception):
    """The node is not started."""


def read(text: str) -> Values:
    """Parameters of each node name, with dots between nested names."""
    events = yaml.parse(text, Loader=yaml.SafeLoader)
    nodes: Values = {}
    for event in events:
        if isinstance(event, MappingStartEvent):
            _mapping(events, (), nodes)
    return nodes


def _mapping(events: Iterator[Event], path: tuple[str, ...], nodes: Values) -> None:
    """The keys of a mapping and what they stand for, into the nodes."""
    while not isinstance(key := next(events), MappingEndEvent):
        if not isinstance(key, ScalarEvent) or not key.value:
            raise RosRefusesError("no key")
        here, event = (*path, key.value), next(events)
        if isinstance(event, MappingStartEvent):
            _mapping(events, here, nodes)
            continue
        if isinstance(event, AliasEvent):
            raise RosRefusesError("will not support aliasing")
        if PARAMETERS not in path[1:]:
            raise RosRefusesError(f"cannot have a value before {PARAMETERS}")
        at = path.index(PARAMETERS)
        value = _value(event) if isinstance(event, ScalarEvent) else _sequence(events)
        nodes.setdefault("/".join(path[:at]), {})[".".join(here[at + 1 :])] = value


def _sequence(events: Iterator[Event]) -> list[Scalar]:
    values = []
    while not isinstance(event := next(events), SequenceEndEvent):
        if not isinstance(event, ScalarEvent):
            raise RosRefusesError("a sequence has values only")
        values.append(_value(event))
    if len({type(value) for value in values}) > 1:
        raise RosRefusesError("sequence should be of same type")
    return values


def _value(event: ScalarEvent) -> Scalar:
    text: str = event.value
    if event.style in QUOTED:
        return text
    if not text:
        raise RosRefusesError("no value")
    if text in TRUE | FALSE:
        return text in TRUE
    if INTEGER.fullmatch(text):
        return int(text, 0)
    try:
        number = float(text)
    except ValueError:
        return text
    return number if number == 0.0 or abs(number) >= SMALLEST else text
