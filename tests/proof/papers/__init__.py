"""Certificates of every kind, made to be looked at."""
