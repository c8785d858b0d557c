"""The calibration items of the specifications, clause by clause, to the letter."""
