"""A station (table, chamber, fixture, unit) and the sequence of a run on it."""
