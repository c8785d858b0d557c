"""Segments of a recording: found, checked, and summarised by their means."""
