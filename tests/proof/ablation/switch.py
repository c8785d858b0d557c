"""Switches one rule or constant of `explain` off, and watches where that would change anything.

A function is replaced wherever it was imported, a constant in the module that is named.
"""

import importlib
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property, wraps
from types import FunctionType
from typing import Any

import numpy as np

ENGINE = "tasks.explain"


@dataclass(frozen=True)
class Switch:
    """A rule, or a constant of one.

    purpose: what it is for. attribute: “module:name” or “module:Class.name” below ENGINE.
    replacement: what stands there when it is off. site: of a constant the function whose outcome
    it may change, named in the same way; a function is its own. every: it is tried on each so
    manieth recording, where it changes numbers on nearly all.
    """

    name: str
    purpose: str
    attribute: str
    replacement: Any
    site: str = ""
    every: int = 1

    @property
    def watched(self) -> str:
        return self.site or self.attribute


@contextmanager
def off(switch: Switch) -> Iterator[None]:
    """The engine without it."""
    with _put(switch.attribute, switch.replacement):
        yield


@dataclass
class Watch:
    """Which switches would have changed an outcome, and in which stages.

    A site's outcome is compared with what it would be without each of its switches, by the same
    arguments: where no call differs, the answer without the switch is the same.
    """

    switches: Sequence[Switch]
    stage: str = ""
    acted: dict[str, set[str]] = field(default_factory=dict)
    _comparing: bool = False

    @contextmanager
    def on(self) -> Iterator[None]:
        by_site: dict[str, list[Switch]] = {}
        for switch in self.switches:
            by_site.setdefault(switch.watched, []).append(switch)
        with ExitStack() as watching:
            for site, own in by_site.items():
                function = _function(site)
                watching.enter_context(_put(site, self._watched(function, own)))
            yield

    def _watched(self, function: FunctionType, own: Sequence[Switch]) -> FunctionType:
        @wraps(function)
        def watched(*args: Any, **named: Any) -> Any:
            outcome = function(*args, **named)
            if self._comparing:
                return outcome
            self._comparing = True
            try:
                for switch in own:
                    if self.stage in self.acted.get(switch.name, ()):
                        continue
                    other = self._without(switch, function, args, named)
                    if not alike(outcome, other):
                        self.acted.setdefault(switch.name, set()).add(self.stage)
            finally:
                self._comparing = False
            return outcome

        return watched  # type: ignore[return-value]

    def _without(
        self, switch: Switch, function: FunctionType, args: Sequence[Any], named: dict[str, Any]
    ) -> Any:
        if not switch.site:
            return switch.replacement(*args, **named)
        with off(switch):
            return function(*args, **named)


def alike(one: Any, other: Any) -> bool:
    """Whether two outcomes are equal, arrays and the fields of data classes element by element."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and bool(np.array_equal(one, other, equal_nan=True))
    if type(one) is not type(other):
        return isinstance(one, int | float) and isinstance(other, int | float) and one == other
    if isinstance(one, float):
        return one == other or (one != one and other != other)
    if is_dataclass(one):
        return all(alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(one[k], other[k]) for k in one)
    return bool(one == other)


def _owner(path: str) -> tuple[Any, str]:
    module, _, name = path.partition(":")
    owner: Any = importlib.import_module(f"{ENGINE}.{module}")
    *classes, last = name.split(".")
    for each in classes:
        owner = getattr(owner, each)
    return owner, last


def _function(path: str) -> FunctionType:
    """The plain function behind a function, method, property or cached property."""
    owner, name = _owner(path)
    raw = vars(owner)[name]
    raw = getattr(raw, "func", None) or getattr(raw, "fget", None) or getattr(raw, "__func__", raw)
    if not isinstance(raw, FunctionType):
        raise TypeError(f"{path} is no function")
    return raw


@contextmanager
def _put(path: str, value: Any) -> Iterator[None]:
    """Another value in its place, of the same kind of attribute, as long as it lasts."""
    owner, name = _owner(path)
    raw = vars(owner)[name]
    places: list[Any]
    if isinstance(owner, type):
        places = [owner]
        value = _as_in_class(raw, name, value)
    elif callable(raw):
        engine = [m for key, m in sys.modules.items() if key.startswith(ENGINE) and m]
        places = [module for module in engine if vars(module).get(name) is raw]
    else:
        places = [owner]
    for place in places:
        setattr(place, name, value)
    try:
        yield
    finally:
        for place in places:
            setattr(place, name, raw)


def _as_in_class(raw: Any, name: str, value: Callable[..., Any]) -> Any:
    if isinstance(raw, cached_property):
        made = cached_property(value)
        made.__set_name__(None, name)  # type: ignore[arg-type]
        return made
    if isinstance(raw, property):
        return property(value)
    if isinstance(raw, classmethod):
        return classmethod(value)
    return value
