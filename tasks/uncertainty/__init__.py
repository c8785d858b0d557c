"""Uncertainty of a result: how it is evaluated and how it is written down."""
