"""A page of history at scale says what was measured, and what it does not hold is not held."""

from dataclasses import replace

import pytest

from storage.formats.content import digest
from tests.proof.history.listing import Listed
from tests.proof.history.local import Again
from tests.proof.history.run import as_page
from tests.proof.history.shared import Shared
from tests.proof.history.store import variations

AGAIN = Again(
    done=10, failed=0, bare_s=0.1, bare_processor_s=0.1, wall_s=1.0, stage_s=0.625,
    processor_s=1.25, prefect_s=0.0125, memory=2**30, load=1.0,
)  # fmt: skip
SHARED = Shared(AGAIN, identical=10, twice=0, happened=("worker killed after 2",))


def test_shares_are_of_the_work_and_of_the_command() -> None:
    assert AGAIN.efficiency == pytest.approx(0.8)
    assert AGAIN.efficiency_of_command == pytest.approx(0.5)
    assert AGAIN.by_processor == pytest.approx(0.8)
    assert AGAIN.prefect == pytest.approx(0.01)


@pytest.mark.parametrize(
    "off", [{"identical": 9}, {"twice": 1}, {"again": replace(AGAIN, failed=1)}], ids=str
)
def test_a_result_that_differs_is_missing_or_twice_is_not_held(off: dict) -> None:
    assert SHARED.holds
    assert not replace(SHARED, **off).holds


def test_the_page_says_it_all() -> None:
    page = as_page(10, AGAIN, SHARED, SHARED, [Listed("SQLite", 10_000, 0.2, 0.1, 0.6, 0.5)])
    assert "| 10 | 0 | 100 | 1 | 80% | 80% | 1.0% | 1.00 | 1 |" in page
    assert "10 of 10 results are bit for bit" in page
    assert "worker killed after 2" in page
    assert "| SQLite | 0.20 | 0.10 | 0.60 | 0.50 |" in page


def test_variations_are_different_recordings_and_always_the_same() -> None:
    first = [digest(each) for each in variations(6)]
    assert len(set(first)) == 6
    assert first[:2] == [digest(each) for each in variations(2)]
