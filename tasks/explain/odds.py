"""How sure a name must be. Evidence is twice the logarithm of odds, which adds to chi-squared."""

from math import log

CERTAIN = 2.0 * log(99.0)  # of a share of 0.99: what differs by less cannot be told apart
