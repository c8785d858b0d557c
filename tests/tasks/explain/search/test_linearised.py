"""What is felt per unit of a parameter is computed once, and only used where it still holds."""

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.search.linearised import Derivatives, FittedModel
from tasks.model.model import Model
from tasks.model.term import Inputs, Parameter, Term
from tasks.model.terms.axes import AXIS_TILT
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion

RUN = motion()
LEVER, DELAY = (0.02, -0.01, 0.03), (0.004,)
BENT, TILTED = (1e-5, 0.0, -2e-5, 0.0, 1e-5, 3e-5), (1e-3, -2e-3)


def model_with(*terms: tuple[Term, tuple[float, ...]]) -> Model:
    """The standard's terms as an ideal unit has them, and others of these values."""
    model = Model.of((*STANDARD_TERMS, *(term for term, _ in terms)))
    for term, values in terms:
        model.values[model.places[term.key]] = values
    return model


@pytest.mark.parametrize(
    "terms",
    [
        [(LEVER_ARM, LEVER)],
        [(STRUCTURAL_COMPLIANCE, BENT)],
        [(AXIS_TILT, TILTED), (LEVER_ARM, LEVER)],
        [(AXIS_TILT, TILTED), (TIME_OFFSET, DELAY)],
    ],
)
def test_columns_and_prediction_are_those_of_central_differences(
    terms: list[tuple[Term, tuple[float, ...]]],
) -> None:
    model = model_with(*terms)
    quick = FittedModel.of_model(model, Derivatives(RUN)).linearised(RUN)
    exact = model.linearised(RUN)
    assert np.array_equal(quick.prediction, exact.prediction, equal_nan=True)
    for one, other in zip(quick.columns, exact.columns, strict=True):
        assert one.keys() == other.keys()
        for channel, column in other.items():
            size = np.nanmax(np.abs(column))
            assert np.nanmax(np.abs(one[channel] - column)) < 0.01 * size
            assert np.array_equal(np.isnan(one[channel]), np.isnan(column))


def test_what_is_felt_is_differentiated_once_for_all_fits_of_a_motion() -> None:
    derivatives = Derivatives(RUN)
    model = FittedModel.of_model(model_with((LEVER_ARM, LEVER)), derivatives)
    model.linearised(RUN)
    first = dict(derivatives.by_shape)
    model.with_term(AXIS_TILT).without({AXIS_TILT.key}).linearised(RUN)
    assert len(first) == len(LEVER)
    assert all(derivatives.by_shape[shape] is column for shape, column in first.items())


class Squared(Term):
    """Adds the square of its parameter to every rate."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        return Inputs(inputs.rate + values[0] ** 2, inputs.force)


def test_derivatives_that_do_not_hold_at_new_values_are_computed_about_these() -> None:
    squared = Squared(
        "squared", "made up", "input", "ω + s²", "none",
        (Parameter("s", "s", "1", "1", (-1.0, 1.0)),),
    )  # fmt: skip
    derivatives = Derivatives(RUN)
    for size, slope in ((0.05, 0.1), (0.1, 0.2), (0.1001, 0.2)):
        model = FittedModel.of_model(model_with((squared, (size,))), derivatives)
        column = model.linearised(RUN).columns[-1]
        assert all(column[c] == pytest.approx(slope) for c in range(3))
