"""A calibration as a correction of readings, for firmware and for other software."""
