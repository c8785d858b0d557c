"""A station that stands for reality: kinematics, filters, clocks and counts, and no model term."""
