"""A list of terms with the values of their parameters and their covariance."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from tasks.model.simulate import Design, linearise, predict, shape_column
from tasks.model.term import Term, TermKey, nominal_values, parameters_of, places
from tasks.motion.whole import Motion

SHAPE_STEP = 0.02  # of a shape's value, to differentiate by it


@dataclass(frozen=True)
class Model:
    """Terms with their values, those that are fitted, and how well they are known.

    values: (p,) of all parameters, SI; free: (p,) bool; covariance: (p, p), zero where not free.
    prior: (p,) precision that the parameters have beforehand, about zero.
    shape_u: for each term the standard uncertainty of its continuous shape, else nothing.
    """

    terms: tuple[Term, ...]
    values: np.ndarray
    free: np.ndarray
    prior: np.ndarray
    covariance: np.ndarray
    shape_u: tuple[float | None, ...]

    @classmethod
    def of(
        cls,
        terms: tuple[Term, ...],
        values: np.ndarray | None = None,
        free: np.ndarray | None = None,
        prior: np.ndarray | None = None,
    ) -> "Model":
        """Terms before a fit: at their nominal values, all free, nothing known beforehand."""
        count = len(parameters_of(terms))
        return cls(
            terms,
            nominal_values(terms) if values is None else values,
            np.ones(count, bool) if free is None else free,
            np.zeros(count) if prior is None else prior,
            np.zeros((count, count)),
            (None,) * len(terms),
        )

    @property
    def u(self) -> np.ndarray:
        """(p,) standard uncertainties; zero where not free."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def without(self, some: Collection[TermKey]) -> "Model":
        """The same values with some terms taken out."""
        kept = [k for k, term in enumerate(self.terms) if term.key not in some]
        own = places(self.terms)
        rows = np.concatenate([np.arange(own[k].start, own[k].stop) for k in kept]).astype(int)
        return Model(
            tuple(self.terms[k] for k in kept), self.values[rows], self.free[rows],
            self.prior[rows], self.covariance[np.ix_(rows, rows)],
            tuple(self.shape_u[k] for k in kept),
        )  # fmt: skip

    def with_term(self, term: Term) -> "Model":
        """The same values with one term more, at its nominal values and free."""
        longer = Model.of((*self.terms, term))
        count = len(self.values)
        longer.values[:count], longer.free[:count] = self.values, self.free
        longer.prior[:count] = self.prior
        longer.covariance[:count, :count] = self.covariance
        return replace(longer, shape_u=(*self.shape_u, None))

    @property
    def places(self) -> dict[TermKey, slice]:
        """Where each term's parameters stand."""
        return dict(zip((term.key for term in self.terms), places(self.terms), strict=True))

    def with_values_of(self, other: "Model") -> "Model":
        """The model with the values that another has for the same terms, where they are free."""
        values, theirs = self.values.copy(), other.places
        for key, place in self.places.items():
            if key in theirs:
                values[place] = other.values[theirs[key]]
        return replace(self, values=np.where(self.free, values, self.values))

    def prediction(self, motion: Motion) -> np.ndarray:
        """Readings (n, 6) in rad/s and m/s² of a unit with these values."""
        return predict(self.terms, motion, self.values)

    def linearised(self, motion: Motion, wanted: np.ndarray | None = None) -> Design:
        """Prediction and columns of all parameters, or of those (p,) bool that are wanted."""
        return linearise(self.terms, motion, self.values, wanted)

    def effect_of(
        self, some: Collection[TermKey], motion: Motion, prediction: np.ndarray
    ) -> np.ndarray:
        """(n, 6) what some of its terms add to its prediction (n, 6)."""
        return prediction - self.without(some).prediction(motion)

    def design(self, motion: Motion) -> Design:
        """Prediction and columns of the free parameters, then of the continuous shapes."""
        whole = self.linearised(motion, self.free)
        columns = [whole.columns[p] for p in np.flatnonzero(self.free)]
        for k in self.fitted_shapes:
            step = SHAPE_STEP * max(abs(self.terms[k].at[0]), 0.1)
            columns.append(shape_column(self.terms, motion, self.values, k, step))
        return Design(whole.prediction, tuple(columns))

    @property
    def fitted_shapes(self) -> list[int]:
        """Terms with one continuous shape in whose columns there is something to differentiate."""
        own = places(self.terms)
        pairs = enumerate(zip(self.terms, own, strict=True))
        return [
            k
            for k, (term, place) in pairs
            if term.has_continuous_shape and self.values[place].any()
        ]

    def stepped(self, change: np.ndarray, covariance: np.ndarray) -> "Model":
        """After a step (q,) of the free parameters and shapes, known by its covariance (q, q)."""
        rows = np.flatnonzero(self.free)
        values, whole = self.values.copy(), np.zeros_like(self.covariance)
        values[rows] += change[: len(rows)]
        whole[np.ix_(rows, rows)] = covariance[: len(rows), : len(rows)]
        terms, shape_u = list(self.terms), list(self.shape_u)
        for n, k in enumerate(self.fitted_shapes, len(rows)):
            now = terms[k].at[0]
            low, high = terms[k].shapes[0].plausible
            longest = 0.5 * max(abs(now), 0.1)
            to = float(np.clip(now + np.clip(change[n], -longest, longest), low, high))
            terms[k] = terms[k].shaped((to,))
            shape_u[k] = float(np.sqrt(covariance[n, n]))
        return replace(
            self, terms=tuple(terms), values=values, covariance=whole, shape_u=tuple(shape_u)
        )

    def held_at_zero(self, some: np.ndarray) -> "Model":
        """Some parameters (p,) bool are zero, and are no longer fitted."""
        left = ~some
        return replace(
            self,
            values=np.where(some, 0.0, self.values),
            free=self.free & left,
            covariance=self.covariance * left[:, None] * left,
        )

    @property
    def negative(self) -> np.ndarray:
        """(p,) bool: below zero where no unit has them, such as a time constant."""
        lowest = np.array([p.plausible[0] for p in parameters_of(self.terms)])
        return np.asarray((lowest == 0.0) & (self.values < 0.0))
