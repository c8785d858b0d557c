"""Recordings made by kinematics of their own, which share no code with what judges them."""
