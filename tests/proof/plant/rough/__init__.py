"""Rough recordings: coarse or late references, bodies moved by hand, loggers that do things.

Everything in them is written from the physics, with parameters of its own; nothing of it is told
to what explains.
"""
