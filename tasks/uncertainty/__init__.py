"""Uncertainty of a result: its evaluation and its notation."""
