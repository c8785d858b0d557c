"""The independent plant: sealed test recordings made from kinematics, filters, clocks and counts.

It shares no code with the estimation. A run is played as attitudes on a grid of 500 Hz or more;
rates come from attitude increments, specific forces from positions differentiated twice.
"""
