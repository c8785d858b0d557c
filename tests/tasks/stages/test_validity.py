"""What a run can be relied on for is judged by its readings as they were recorded."""

from collections.abc import Callable
from pathlib import Path

from schemas.calibration import AdoptedTerm
from schemas.recording import Recording
from schemas.text import Remark
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages.estimate import estimate
from tasks.stages.validity import validity_of


def test_a_result_less_known_physics_does_not_judge_the_run(
    ideal_run: Callable[..., Recording], tmp_path: Path
) -> None:
    home = Home(tmp_path)
    run, _ = runs.add(ideal_run(dwell=1.0), home)
    made = estimate(run, home)
    plain = validity_of(run, home)
    term = AdoptedTerm(name="lever_arm", title="a lever arm", title_zh="杆臂", parameters=())
    doubt = Remark(code="doubt", en="not of the run", zh="与本次运行无关", run="invalid")
    remarks = (*made.remarks, doubt)
    less = made.model_copy(update={"terms": (term,), "remarks": remarks})
    assert less.validity != plain
    results.save(less, home)
    assert validity_of(run, home) == plain
