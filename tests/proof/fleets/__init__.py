"""Sealed fleets: many runs of many units on some stations, and who in them carries an effect."""
