"""What a review says: numbers, carriers and sentences in both languages."""

import numpy as np
import pytest

from schemas.discrepancy import Consequence, Review
from schemas.recording import Manifest
from tasks.calibrate.calibrate import calibrate
from tasks.motion.table import EARTH_RATE
from tasks.review.hypotheses import Effect
from tasks.review.pool import statistics_of
from tasks.review.report import estimated, moved_elements, review_of, touched_of, with_touched
from tasks.review.search import search
from tasks.review.several_recordings import reviewed_runs
from tasks.specifications.register import specification_for
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate
from tests.tasks.review.fleet import fleet, of

SIZE = 3.0


def reviewed(*args: object, **more: object) -> Review:
    pool = fleet(*args, **more)  # type: ignore[arg-type]
    return review_of(pool, *search(pool))


def test_a_change_is_told_with_its_run_and_interval():
    review = reviewed(4, lambda unit, station, day: of("axis_tilt", SIZE * (day >= 50)))
    (finding,) = review.findings
    assert (review.verdict, finding.effect) == ("explained", "axis_tilt")
    assert finding.since is not None
    assert finding.since.run in finding.statement.en
    assert finding.since.run in finding.statement.zh
    assert finding.since.earliest <= finding.since.at <= finding.since.latest
    assert finding.since.without < finding.since.earliest
    assert finding.evidence.runs_that_show_it > 0.8 * finding.evidence.runs
    assert finding.parameters[0].value == pytest.approx(SIZE, abs=5 * finding.parameters[0].u)


def test_carriers_that_cannot_be_told_apart_are_named_with_the_run_that_would():
    review = reviewed(
        7, lambda unit, station, day: of("axis_tilt", SIZE * (unit == 3)),
        runs=120, units=8, station_of=lambda unit: unit,
    )  # fmt: skip
    (finding,) = review.findings
    assert review.verdict == "partly_explained"
    assert [(each.level, each.carrier) for each in finding.alternatives] == [("station", "S3")]
    assert "another unit on this station" in finding.statement.en


def test_a_site_is_estimated_from_the_level_part_of_earths_rotation():
    latitude, heading, u = np.radians(39.9), np.radians(30.0), 1e-7
    level = EARTH_RATE * np.cos(latitude) * np.array([-np.sin(heading), np.cos(heading)])
    site = estimated("ST-01", 12, level, np.diag([u**2, u**2]))
    assert site.latitude_deg == pytest.approx(39.9, abs=1e-6)
    assert site.heading_deg == pytest.approx(30.0, abs=1e-6)
    assert site.latitude_expanded == pytest.approx(
        2 * np.degrees(u / (EARTH_RATE * np.sin(latitude)))
    )


def manifest(model: str, serial: str, **station: object) -> Manifest:
    return Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": f"{model}-{serial}",
        "unit": {"manufacturer": "A", "model": model, "serial": serial},
        "station": {"id": "ST-01"} | station,
    })  # fmt: skip


def test_units_go_by_their_serial_unless_two_models_share_it():
    runs = reviewed_runs({
        "a": manifest("M1", "1", site="north"), "b": manifest("M2", "1", latitude_deg=40.0),
        "c": manifest("M2", "2"),
    })  # fmt: skip
    assert [run.carriers["unit"] for run in runs.values()] == ["M1 1", "M2 1", "2"]
    assert [run.carriers.get("site") for run in runs.values()] == ["north", "40.00°", None]


# What an effect moves in a certificate is what a recording without it would have given.

QUADRATIC = (2e-3, -1e-3, 1.5e-3)  # of an accelerometer's reading in g


def case(*effects: EffectCall) -> Case:
    return Case(seed=1, procedure="rests", rate_hz=20, dwell_s=5.0, effects=effects)


def test_the_elements_move_by_what_the_effect_did_to_them():
    parameters = {"coefficient": list(QUADRATIC), "order": 2}
    call = EffectCall(name="accel_nonlinearity", parameters=parameters)
    bent, plain = simulate(case(call)).recording, simulate(case()).recording
    named = [each for each in statistics_of(bent).layout.terms if each.name == call.name]
    term = next(each for each in named if each.at == (2.0,))
    elements = moved_elements(bent, Effect(term, (0, 1, 2)), np.array(QUADRATIC))
    truth = calibrate(specification_for(plain.manifest.standard), plain, run="", code_version="")
    assert {"x", "y", "z"} <= {each.element for each in elements if each.item == "accel_bias"}
    for each in elements:
        assert each.U is not None
        without = truth.items[each.item].value[each.element]
        assert each.after == pytest.approx(without, abs=0.2 * each.U)


def test_a_finding_tells_what_it_moves_the_most_first():
    pool = fleet(1, lambda unit, station, day: of("axis_tilt", 2.0 * (station == 2)))
    (finding,) = review_of(pool, *search(pool)).findings
    moved = [
        Consequence(item="gyro_bias", element=e, before=0.0, after=a, U=0.1, unit="deg/s")
        for e, a in (("x", 0.02), ("y", -0.3))
    ]
    complete = with_touched(finding, list(touched_of("C-1", moved)), 3)
    assert [(each.element, round(each.in_U, 3)) for each in complete.touched] == [
        ("y", -3.0), ("x", 0.2)
    ]  # fmt: skip
    assert "1 of 3; largest change: C-1" in complete.statement.en
    assert "C-1" in complete.statement.zh
    assert "0.05 U" in with_touched(finding, [], 3).statement.en
    assert with_touched(finding, [], 0) == finding
