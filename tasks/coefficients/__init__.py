"""A calibration as the correction of readings, for firmware and for other software."""
