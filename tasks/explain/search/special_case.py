"""Tells a lever arm from the more general forms of which it is the special case.

What fits a recording of a lever arm fits as well with the size effect, places alike; whether it
could show that the accelerometers are apart decides whether the lever arm stands alone. Nine free
factors of the angular acceleration are a lever arm where they are antisymmetric, ω̇×r.
"""

from collections.abc import Sequence

import numpy as np

from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.scores import projected
from tasks.model.regression import inverse
from tasks.model.term import Term

HOLDS = {"lever_arm": "size_effect"}  # special case: general effect
BY_EQUATION = {"reading += c·ω̇": "lever_arm"}  # general form without a name: special case
APART = np.array([[1.0, 0.0, -1.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])  # accelerometer, component
# Chi-squared that a typical departure is to show: of six independent components, so that one in
# twenty shows a quarter of it.
SHOWN = 60.0


def special_cases(general: Term) -> tuple[str, ...]:
    """Names of the catalogue that a term holds as special cases."""
    named = (name for name, effect in HOLDS.items() if effect == general.name)
    unnamed = BY_EQUATION.get(general.equation)
    return (*named, *([unnamed] if unnamed else []))


def places_apart(r: np.ndarray) -> np.ndarray:
    """(9,) places (m) of three accelerometers that are as far apart as their mean r (3,) is from
    the axes.
    """
    return np.asarray((r + np.linalg.norm(r) / np.sqrt(3.0) * APART).ravel())


def departure_shown(
    equations: NormalEquations, general: Candidate, others: Sequence[Candidate], r: np.ndarray
) -> float:
    """Expected chi-squared of places that are apart by as much as r (3,) m is long, beside what
    their mean and other candidates may take of it.

    The columns of the places that the data move, of nine, are of unit size: their scale is divided
    out. S = G − GB(BᵀGB)⁻¹BᵀG with B the places alike; components of σ² = r²/3 show σ²·tr(S).
    """
    places = list(general.members)
    left, size = projected(equations, others), equations.power[places] ** 0.5
    information = left.normal[np.ix_(places, places)] * np.outer(size, size)
    alike = np.tile(np.eye(3), (3, 1))[list(general.own)]
    along = information @ alike
    apart = information - along @ inverse(alike.T @ along) @ along.T
    return float(np.trace(apart) * (r @ r) / 3.0)
