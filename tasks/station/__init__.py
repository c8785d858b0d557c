"""A station and what is done with it: table, chamber, unit, and the sequence of a run."""
