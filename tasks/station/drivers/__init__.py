"""The drivers that there are: what speaks to a table, a chamber, a fixture or a unit."""
