"""Stage: what cannot be explained together is refused in one sentence."""

from pathlib import Path

import pytest

from schemas.base import Unusable
from schemas.orders import ExplainOrder
from storage.catalogue import runs
from storage.home import Home
from tasks.stages.explain_several import explain_together
from tests.drafts import recording_of


def test_recordings_of_different_units_are_refused(tmp_path: Path) -> None:
    home = Home(tmp_path)
    which = [runs.add(recording_of(serial), home)[0] for serial in ("1", "2")]
    with pytest.raises(Unusable, match=r"different units \(Maker U 1, Maker U 2\)"):
        explain_together(which, home, ExplainOrder(run=which[0].id, others=(which[1].id,)))


def test_a_recording_named_twice_is_refused(tmp_path: Path) -> None:
    home = Home(tmp_path)
    run, _ = runs.add(recording_of("1"), home)
    with pytest.raises(Unusable, match="named twice"):
        explain_together([run, run], home, ExplainOrder(run=run.id, others=(run.id,)))
