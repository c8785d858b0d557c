"""Validity of a run, decided before the unit: each check with its limit and its reason."""
