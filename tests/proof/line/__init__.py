"""A laboratory with years behind it: its runs, their results and certificates as one store."""
