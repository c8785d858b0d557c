"""Statistics of a line: yield, capability, control charts, station against station."""
