"""How sure a name must be, and how exactly a form is known.

Evidence is twice the logarithm of odds, which adds to chi-squared. Data of one model favour another
by a likelihood ratio k with a probability of 1/k at most (Royall, Statistical Evidence, 1997,
section 1.4): by so much to name one alone. What a form lacks is a random effect of a variance in
proportion to what the form explains; beside it evidence counts less.
"""

from math import log

COVERAGE = 2.0  # standard uncertainties in U
CERTAIN = 2.0 * log(99.0)  # of a share of 0.99: what differs by less cannot be told apart
PUBLISHED = 0.03  # relative: by which units depart from a published equation
UNPUBLISHED = 0.12  # the same of what is called by its behaviour, or not found


def as_likely_within(gain: float) -> float:
    """By how much the evidence of another name may be less than that of a name that gains so much
    chi-squared by a published form, and the two cannot be told apart.
    """
    return CERTAIN * (1.0 + PUBLISHED**2 * max(gain, 0.0))
