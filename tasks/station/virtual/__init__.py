"""A virtual station: kinematics, filters, clocks and counts, without any term of the models."""
