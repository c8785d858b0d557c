"""The latitude of a recording against that of the laboratory."""

from collections.abc import Callable

import pytest

from schemas.recording import Recording
from storage.catalogue import runs
from storage.home import Home
from tasks.stages.estimate import estimate, validity_of
from tests.manifests import at_station

LABORATORY = """
format = "mimu-laboratory/1"
latitude_deg = {latitude}
party = {{ name = "L", name_zh = "实", address = "a", address_zh = "址" }}
"""
SENTENCE = "The recording states a latitude of 39.9°, but that of the laboratory is -39.9°."


@pytest.fixture
def at_39_9(ideal_run: Callable[..., Recording]) -> Recording:
    return at_station(ideal_run(dwell=1.0), latitude_deg=39.9)


@pytest.mark.parametrize(("own", "contradicted"), [(39.9, 0), (39.95, 0), (-39.9, 1)])
def test_a_latitude_that_is_not_the_laboratorys_makes_the_run_invalid(
    own, contradicted, at_39_9, tmp_path
):
    (tmp_path / "laboratory.toml").write_text(LABORATORY.format(latitude=own), encoding="utf-8")
    run, _ = runs.add(at_39_9, Home(tmp_path))
    about_latitude = [
        r for r in estimate(run, Home(tmp_path)).remarks if r.code == "laboratory_latitude"
    ]
    assert [remark.run for remark in about_latitude] == ["invalid"] * contradicted


def test_it_is_said_as_soon_as_the_run_is_there(at_39_9, tmp_path):
    (tmp_path / "laboratory.toml").write_text(LABORATORY.format(latitude=-39.9), encoding="utf-8")
    run, _ = runs.add(at_39_9, Home(tmp_path))
    assert SENTENCE in validity_of(run, Home(tmp_path)).reasons
