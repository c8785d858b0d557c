"""Effects of the findings on the calibration items, and a calibration corrected for them."""
