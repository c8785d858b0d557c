"""A logger's table taken into the store: what was understood is shown first."""
