"""Uncertainties that hold where residuals hang together and are not alike everywhere."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tasks.explain.evidence.cells import CellInfluence, cell_influence
from tasks.explain.evidence.form_errors import named_beside, undetermined
from tasks.explain.explanation import CERTAIN, PUBLISHED, UNNAMED, UNPUBLISHED, Finding

# A name stands only where its evidence is more than the forms of everything else may leave.

NOISE, NOTHING = np.ones(6), np.zeros(6)
EVERYWHERE = np.ones((1000, 6))
NAMED = Finding(
    effect="lever_arm", family="geometry", title="lever arm", equation="", source="",
    channels=(3, 4), parameters=(), contribution=EVERYWHERE * [0, 0, 0, 1, 1, 0],
    gain=60.0, delta_bic=50.0, held_out_gain=30.0, indistinguishable=("size_effect",),
    behaviour="the angular acceleration",
)  # fmt: skip
STRONG = replace(NAMED, effect="accel_nonlinearity", gain=9000.0, delta_bic=8900.0)


def names(
    *findings: Finding, left: np.ndarray = NOTHING, scale: np.ndarray = NOISE, **more: object
) -> list[str]:
    named = named_beside(findings, (), left, scale, NOISE, **more)  # type: ignore[arg-type]
    return [one.effect for one in named]


def test_a_weak_name_beside_something_far_stronger_is_an_error_of_its_form() -> None:
    lost, kept = named_beside([NAMED, STRONG], (), NOTHING, NOISE, NOISE)
    assert kept is STRONG
    assert (lost.effect, lost.title) == (UNNAMED, "the angular acceleration")
    assert lost.indistinguishable == ()
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.name) == ("form_error", "lever_arm")
    assert lost.refusal.value == pytest.approx(150.0)


def test_what_acts_on_other_channels_leaves_nothing_in_these() -> None:
    gyros = replace(STRONG, channels=(0,), contribution=EVERYWHERE * [1, 0, 0, 0, 0, 0])
    assert names(NAMED, gyros) == ["lever_arm", "accel_nonlinearity"]


def test_what_was_put_right_first_leaves_form_errors_too() -> None:
    (lost,) = named_beside([NAMED], [replace(STRONG, effect="code_fault")], NOTHING, NOISE, NOISE)
    assert lost.effect == UNNAMED


def test_what_has_no_name_leaves_more_than_a_published_equation() -> None:
    other = replace(STRONG, gain=1000.0)
    assert names(NAMED, other)[0] == "lever_arm"
    assert names(NAMED, replace(other, effect=UNNAMED))[0] == UNNAMED


def test_beside_what_nothing_explains_in_its_channels_a_weak_name_is_withdrawn() -> None:
    left = np.array([0.0, 0.0, 0.0, 600.0, 0.0, 0.0])
    (lost,) = named_beside([NAMED], (), left, NOISE, NOISE)
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.value) == ("overshadowed", pytest.approx(10.0))
    assert names(replace(NAMED, gain=6000.0, delta_bic=5990.0), left=left) == ["lever_arm"]
    assert names(NAMED, left=np.roll(left, 3)) == ["lever_arm"]


@pytest.mark.parametrize(("gain", "most"), [(300.0, 20.0), (3e4, 2000.0), (3e6, 2e5)])
def test_the_more_is_left_in_its_channels_the_more_a_name_must_gain(
    gain: float, most: float
) -> None:
    """most: χ² per degree of freedom of what is left, at which nothing of such a gain is named."""
    one = replace(NAMED, gain=gain, delta_bic=gain - 10.0)
    assert names(one, scale=np.full(6, np.nan)) == names(one) == ["lever_arm"]
    assert names(one, scale=np.full(6, 0.1 * most)) == ["lever_arm"]
    assert names(one, scale=np.full(6, most)) == [UNNAMED]
    assert names(one, scale=np.array([most, most, most, 1.0, 1.0, most])) == ["lever_arm"]
    (lost,) = named_beside([one], (), NOTHING, np.full(6, most), NOISE)
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.limit) == ("overshadowed", most)


@pytest.mark.parametrize("other", [{"effect": "hysteresis"}, {"unlisted": True}])
def test_one_form_of_a_memory_or_an_unlisted_one_leaves_as_much_as_what_has_no_name(
    other: dict[str, object],
) -> None:
    strong = replace(STRONG, gain=2000.0, **other)  # type: ignore[arg-type]
    walk = replace(NAMED, effect="bias_random_walk")
    assert names(walk, replace(STRONG, gain=2000.0))[0] == "bias_random_walk"
    assert names(walk, strong)[0] == UNNAMED


def test_what_every_model_contains_is_no_form_error_but_may_be_overshadowed() -> None:
    frame = replace(NAMED, effect="reference_frame")
    assert names(frame, STRONG)[0] == UNNAMED
    assert names(frame, STRONG, nuisances=("reference_frame",))[0] == "reference_frame"
    left = np.full(6, 600.0)
    assert names(frame, left=left, nuisances=("reference_frame",)) == [UNNAMED]


def test_physics_that_is_known_beforehand_keeps_its_name() -> None:
    assert names(replace(NAMED, behaviour=""), STRONG, left=np.full(6, 1e5))[0] == "lever_arm"


@pytest.mark.parametrize(
    ("form", "strong"), [(PUBLISHED, STRONG), (UNPUBLISHED, replace(STRONG, effect=UNNAMED))]
)
def test_a_form_error_of_the_stated_size_gets_a_name_in_one_of_a_hundred(
    form: float, strong: Finding
) -> None:
    """Of an effect that is not there, fitted to noise and to what the form of a strong one lacks:
    its gain is the square of a normal variable with the variance 1 + τ²·g.
    """
    rng = np.random.default_rng(7)
    sizes = rng.standard_normal(400) * np.sqrt(1.0 + form**2 * strong.gain)
    weak = [replace(NAMED, gain=size**2, delta_bic=size**2) for size in sizes.tolist()]
    named = sum(names(one, strong)[0] != UNNAMED for one in weak)
    assert named <= 0.01 * len(weak)  # 2·ln 99 of a normal variable is exceeded by 0.0024
    assert pytest.approx(2.0 * np.log(99.0), abs=0.02) == CERTAIN


CELLS, ROWS = 40, 60
SLOPE = 2.0


def influence(
    rng: np.random.Generator, wander: float, uneven: float
) -> tuple[CellInfluence, float]:
    """A slope and an offset in rows of unit noise, to which each cell adds an offset and a slope
    of its own (wander), the more the larger the regressor is there (uneven).
    """
    normal, right = np.zeros((CELLS, 2, 2)), np.zeros((CELLS, 2))
    for cell in range(CELLS):
        size = 0.3 + 2.0 * rng.random()
        x = size * rng.standard_normal(ROWS)
        columns = np.column_stack([np.ones(ROWS), x])
        off = columns @ rng.standard_normal(2) * wander * (1.0 + uneven * size)
        reading = SLOPE * x + off + rng.standard_normal(ROWS)
        normal[cell], right[cell] = columns.T @ columns, columns.T @ reading
    found, change = cell_influence(normal, right, [1], np.zeros(2), np.zeros(2))
    return found, float(change[0])


@pytest.mark.parametrize(("wander", "uneven"), [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0)])
def test_intervals_hold_the_truth_as_often_as_stated(wander: float, uneven: float) -> None:
    rng = np.random.default_rng(7)
    inside = []
    for _ in range(300):
        found, slope = influence(rng, wander, uneven)
        u = np.sqrt(found.covariance[0, 0] * found.dispersion)
        inside.append(abs(slope - SLOPE) < 2.0 * u)
    assert 0.90 < np.mean(inside) < 0.99


def test_where_only_noise_is_left_nothing_is_widened() -> None:
    rng = np.random.default_rng(8)
    widened = [influence(rng, 0.0, 0.0)[0].dispersion > 1.0 for _ in range(200)]
    assert np.mean(widened) < 0.02


def test_what_hangs_together_in_cells_counts_by_cells() -> None:
    """Offsets of 1 and slopes of 1 in cells of 60 rows: nearly sixty times the white variance."""
    found, _ = influence(np.random.default_rng(9), 1.0, 0.0)
    assert 20.0 < found.dispersion < 200.0
    assert found.degrees == pytest.approx(found.effective_cells.sum())
    assert 10.0 < found.degrees < CELLS


def test_columns_that_are_projected_out_do_not_matter() -> None:
    """Neither scatter nor covariance change where the other column is another mix of both."""
    rng = np.random.default_rng(10)
    normal = np.array([(lambda a: a.T @ a)(rng.standard_normal((ROWS, 2))) for _ in range(CELLS)])
    right = rng.standard_normal((CELLS, 2)) * 10.0
    mixed = np.array([[1.0, 0.7], [0.0, 1.0]])  # new columns: c0, c0·0.7 + c1
    first, slope = cell_influence(normal, right, [1], np.zeros(2), np.zeros(2))
    turned = np.linalg.inv(mixed)
    other, same = cell_influence(
        turned.T @ normal @ turned, right @ turned, [1], np.zeros(2), np.zeros(2)
    )
    assert same == pytest.approx(slope, rel=1e-6)
    assert other.robust_covariance == pytest.approx(first.robust_covariance, rel=1e-6)


# Which parameters are held at nothing: one after the other, the least clear first.


def held(values: tuple[float, ...], covariance: np.ndarray) -> list[bool]:
    """Of one finding whose parameters have these values, be it of one effect or of several."""
    count = len(values)
    model: Any = SimpleNamespace(values=np.array(values), covariance=covariance)
    return undetermined(model, [set(range(count))], np.ones(count)).tolist()


def test_what_is_no_larger_than_its_u_is_held_at_nothing() -> None:
    assert held((5.0, 1.9, -2.1), np.eye(3)) == [False, True, False]


@pytest.mark.parametrize("r", [0.99, -0.99])
def test_of_two_that_make_up_for_each_other_one_stays(r: float) -> None:
    """Neither is larger than its U, but without the one the other is clear."""
    covariance = np.eye(3)
    covariance[1, 2] = covariance[2, 1] = -r
    values = (9.0, 1.5, np.sign(r) * 1.4)
    assert held(values, covariance) == [False, False, True]


def test_the_last_of_a_finding_stays() -> None:
    assert held((0.3, 0.1), np.eye(2)) == [False, True]
