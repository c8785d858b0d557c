"""One calibration over a specification: evidence, items, uncertainties, the result."""
