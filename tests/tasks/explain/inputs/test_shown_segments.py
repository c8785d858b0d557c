"""A report knows no rest in which the poses turn."""

from dataclasses import replace

from tasks.explain.inputs.shown_segments import shown_segments
from tasks.segments.find import segments_of
from tests.moved_by_hand import poses, readings, recording

BY_HAND = recording(readings(seconds=40.0), poses(seconds=40.0))


def test_no_rest_is_shown_where_poses_turn() -> None:
    (found,) = segments_of(BY_HAND)
    assert found.kind == "static"
    assert shown_segments(BY_HAND) == ()


def test_labels_stay_as_they_are() -> None:
    label = {"name": "rest", "kind": "static", "t_start": 25.0, "t_end": 35.0}
    manifest = BY_HAND.manifest
    labelled = manifest.model_validate({**manifest.model_dump(), "segments": [label]})
    one = replace(BY_HAND, manifest=labelled)
    assert shown_segments(one) == segments_of(one)
