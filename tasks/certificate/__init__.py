"""The calibration certificate of clause 8 of JJF 2003-2022 and its contents."""
