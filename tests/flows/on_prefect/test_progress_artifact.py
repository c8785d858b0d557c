"""Progress on Prefect's pages: rare updates, rarer ones while the server does not answer."""

import pytest

from flows.on_prefect import artifacts
from flows.on_prefect.artifacts import PROGRESS_EVERY_S, UNANSWERED_S, ProgressArtifact


@pytest.mark.parametrize(("answers", "pause_s"), [(True, PROGRESS_EVERY_S), (False, UNANSWERED_S)])
def test_an_update_comes_after_a_pause_and_at_the_end(
    monkeypatch: pytest.MonkeyPatch, answers: bool, pause_s: float
) -> None:
    updates: list[int] = []
    now = [0.0]
    monkeypatch.setattr(artifacts, "show", lambda update: updates.append(1) or answers)
    show = ProgressArtifact("reprocess", clock=lambda: now[0])
    for second in range(200):
        now[0] = float(second)
        show(second, 200)
    assert len(updates) == 1 + int(199 // pause_s)
    show(200, 200)
    assert len(updates) == 2 + int(199 // pause_s)
