"""The evidence for each selected effect, also on held-out segments, and the findings from it."""
