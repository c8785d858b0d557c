"""Results: kept once, never overwritten, each superseding the one before and saying why."""

from collections.abc import Callable

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from schemas.calibration import AdoptedTerm
from storage import dataframes
from storage.catalogue import database, results, runs, tables
from storage.home import Home
from tests.storage.small import calibrated, small


def test_result_comes_back_as_it_went_in(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    assert results.of_run(run, fresh) == []
    results.save(calibrated(run), fresh)
    (kept,) = results.of_run(run, fresh)
    assert kept.calibration == calibrated(run)


def test_new_result_supersedes_the_older_and_says_why(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    one = results.save(calibrated(run), fresh)
    two = results.save(calibrated(run, 0.5, code_version="2"), fresh)
    three = results.save(calibrated(run, 0.75, code_version="2"), fresh, why="table was off")
    four = results.save(calibrated(run, 0.5, code_version="2"), fresh)
    kept = results.of_run(run, fresh)
    assert [result.id for result in kept] == [one, two, three, four]
    assert [result.supersedes for result in kept] == [None, one, two, three]
    assert [result.why for result in kept] == [
        None,
        "made with another code_version (1 to 2)",
        "table was off",
        "other values, made the same",
    ]
    assert kept[3].calibration == kept[1].calibration


def test_methods_do_not_supersede_each_other(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    results.save(calibrated(run), fresh)
    results.save(calibrated(run, 0.5, method="joint"), fresh)
    assert [result.supersedes for result in results.of_run(run, fresh)] == [None, None]


def test_a_result_with_further_terms_stands_beside_the_one_without(fresh: Home) -> None:
    """Each line of results goes on by itself, whichever was kept last."""
    run = runs.add(small(), fresh)[0]
    arm, tilt = (AdoptedTerm(name=name, title="t", title_zh="t") for name in ("arm", "tilt"))
    plain = results.save(calibrated(run), fresh)
    armed = results.save(calibrated(run, 0.5, terms=(arm,)), fresh)
    both = results.save(calibrated(run, 0.5, terms=(arm, tilt)), fresh)
    assert results.save(calibrated(run), fresh) == plain
    later = results.save(calibrated(run, 0.7, terms=(arm,)), fresh)
    kept = {result.id: result.supersedes for result in results.of_run(run, fresh)}
    assert kept == {plain: None, armed: None, both: None, later: armed}
    newest = results.newest(results.of_run(run, fresh))
    assert newest is not None
    assert newest.id == results.find(run.id, fresh).id == plain
    table = dataframes.results(fresh).groupby("result")["terms"].first()
    assert dict(table) == {plain: "", armed: "arm", both: "arm tilt", later: "arm"}


def test_a_result_is_found_by_its_id(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    kept = results.save(calibrated(run, 0.5), fresh)
    assert results.find(kept, fresh).calibration == calibrated(run, 0.5)
    with pytest.raises(Unusable, match="no result 'c0'"):
        results.find("c0", fresh)


def test_result_of_a_run_that_is_not_kept_is_refused(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    for stranger in ({"run": "r0"}, {"digest": "0" * 64}):
        with pytest.raises(Unusable, match="import the recording first"):
            results.save(calibrated(run).model_copy(update=stranger), fresh)


def test_results_saved_at_once_form_one_line(
    either: Home, at_once: Callable[..., list[str]]
) -> None:
    run = runs.add(small(), either)[0]
    script = """
import os
from schemas.calibration import AdoptedTerm, Calibration
document = Calibration.model_validate_json(arguments[0])
print(results.save(document.model_copy(update={"code_version": str(os.getpid())}), home))
"""
    at_once(script, either, calibrated(run).model_dump_json(), processes=3)
    kept = results.of_run(run, either)
    assert [result.supersedes for result in kept] == [None, kept[0].id, kept[1].id]


def test_document_that_cannot_be_read_is_named_and_can_be_superseded(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    one = results.save(calibrated(run), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.results).values(document="{}"))
    with pytest.raises(Unusable, match=f"result {one} cannot be read"):
        results.of_run(run, fresh)
    assert results.save(calibrated(run), fresh) != one
