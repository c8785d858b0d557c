"""Readings put right once, before any model: stamps, rows, codes, units, signs, rests, noise."""
