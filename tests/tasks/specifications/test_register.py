"""The records of specifications: complete, consistent, and in every language."""

import pytest

from tasks.specifications.estimate import ITEMS
from tasks.specifications.readings import READINGS
from tasks.specifications.register import BY_STANDARD, SPECIFICATIONS, specification_for
from tasks.words import known, say

METHODS = pytest.mark.parametrize("specification", SPECIFICATIONS.values(), ids=SPECIFICATIONS)


@METHODS
def test_every_item_stands_once_in_the_layout(specification):
    keys = [item.key for item in specification.items]
    assert sorted(key for section in specification.layout for key in section.items) == sorted(keys)
    assert len(set(keys)) == len(keys)
    assert all(ITEMS[item.key] == item for item in specification.items)


@METHODS
def test_every_title_is_in_the_catalogues(specification):
    assert all(known(section.title.id) for section in specification.layout)
    for item in specification.items:
        names = {say(item.element_title(e), "en") for e in item.elements}
        assert known(item.title.id)
        assert len(names) == len({item.symbol(e) for e in item.elements}) == len(item.elements)


@pytest.mark.parametrize("reading", READINGS.values(), ids=READINGS)
def test_every_reading_is_in_the_catalogues(reading):
    assert known(reading.text.id)


def test_a_recording_without_a_standard_is_calibrated_by_jjf_2003():
    assert specification_for("other") is BY_STANDARD["JJF 2003-2022"]
    assert specification_for("JJF 1536-2015").method == "jjf1536"
    assert specification_for("JJF 1536-2015", "joint").method == "joint"
