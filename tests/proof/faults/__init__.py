"""Runs on a station in which something fails at a random time, and what became of them."""
