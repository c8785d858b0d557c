"""Doubts about an item that prevent a decision on it."""

from collections.abc import Mapping
from dataclasses import dataclass

from tasks.words import Sayable


@dataclass(frozen=True)
class Doubt:
    """Why nothing is decided on an item; elements: on which of it, None: on any."""

    sentence: Sayable
    elements: frozenset[str] | None = None

    def about(self, element: str) -> bool:
        """Whether it is a doubt about an element; one about the whole item is about each."""
        return self.elements is None or element == "all" or element in self.elements


Doubts = Mapping[str, Doubt]  # by item


def is_doubted(doubts: Doubts, item: str, element: str) -> bool:
    """Whether nothing can be decided on an element of an item."""
    return item in doubts and doubts[item].about(element)
