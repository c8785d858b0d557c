"""Stretches of a recording: found, checked, and summarised to means."""
