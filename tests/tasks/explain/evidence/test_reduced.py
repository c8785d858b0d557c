"""The equations of a fit say what the fit of fewer findings says."""

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, read, selected

from tasks.explain.evidence import pruning
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.pruning import pruned
from tasks.explain.evidence.reduced import without
from tasks.model.term import Term
from tasks.model.terms.electronics import BANDWIDTH
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
ARM = np.array([0.01, -0.02, 0.015])
TERMS: tuple[Term, ...] = (LEVER_ARM, TEMPERATURE_BIAS, STRUCTURAL_COMPLIANCE)


def readings() -> np.ndarray:
    return read(RUN, (LEVER_ARM, ARM)) + noise(len(RUN.t), 71, NOISY)


@pytest.mark.parametrize("left_out", range(3))
def test_evidence_by_equations_is_that_of_the_fit_without_the_finding(left_out: int) -> None:
    fit = selected(readings(), *TERMS)
    by_equations = without(Evidence.of(fit), left_out)
    fitted = Evidence.of(selected(readings(), *(t for n, t in enumerate(TERMS) if n != left_out)))
    assert [each.name for each in by_equations.groups] == [each.name for each in fitted.groups]
    assert by_equations.chi2 == pytest.approx(fitted.chi2, rel=1e-3)
    for number in range(2):
        assert by_equations.gain(number) == pytest.approx(fitted.gain(number), rel=0.02, abs=0.1)
        assert by_equations.held_out_gain(number) == pytest.approx(
            fitted.held_out_gain(number), rel=0.02, abs=0.1
        )
        assert by_equations.scatter.dispersion(number) == pytest.approx(
            fitted.scatter.dispersion(number), rel=0.02
        )
        u = fitted.u(number)
        assert by_equations.u(number) == pytest.approx(u, rel=0.02)
        assert (np.abs(by_equations.own[number][1] - fitted.own[number][1]) < 0.1 * u).all()


def test_what_could_only_be_negative_is_left_out_with_the_finding() -> None:
    """Stamps that are late beside a low-pass: without the delay the low-pass makes up for it."""
    made = read(RUN, (TIME_OFFSET, [-0.004])) + noise(len(RUN.t), 72, NOISY)
    both = Evidence.of(selected(made, TIME_OFFSET, BANDWIDTH))
    alone = without(both, 0)
    assert (alone.own[0][1] >= 0.0).all()


def test_several_needless_findings_take_one_fit_more(monkeypatch: pytest.MonkeyPatch) -> None:
    made = read(RUN) + noise(len(RUN.t), 73, NOISY)
    fit, fits = selected(made, *TERMS), []
    own = pruning._fitted
    monkeypatch.setattr(pruning, "_fitted", lambda one: fits.append(one) or own(one))
    assert pruned(fit, 300).groups == ()
    assert len(fits) == 1


@pytest.mark.rehearsal
def test_where_the_fit_is_not_what_the_equations_said_each_is_decided_by_a_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = read(RUN) + noise(len(RUN.t), 73, NOISY)
    fit, fits = selected(made, *TERMS), []
    own = pruning._fitted
    monkeypatch.setattr(pruning, "_fitted", lambda one: fits.append(one) or own(one))
    monkeypatch.setattr(pruning, "_agree", lambda fitted, by_equations: False)
    assert pruned(fit, 300).groups == ()
    assert len([one for one in fits if len(one.groups) == 2]) == 1
    assert len([one for one in fits if len(one.groups) == 1]) == 1
