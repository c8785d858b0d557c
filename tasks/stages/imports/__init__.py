"""A logger's table, imported into the store: what was understood is shown first."""
