"""Frozen models of everything that is ordered, stored, exchanged or printed."""
