"""How sure a name must be, and how exactly a form is known.

Evidence is twice the logarithm of odds, which adds to chi-squared. What a form lacks is a random
effect of a variance in proportion to what the form explains; beside it evidence counts less.
"""

from math import log

CERTAIN = 2.0 * log(99.0)  # of a share of 0.99: what differs by less cannot be told apart
PUBLISHED = 0.03  # relative: by which units depart from a published equation
UNPUBLISHED = 0.12  # the same of what is called by its behaviour, or not found
