"""What the findings do to the calibration items, and a calibration corrected for them."""
