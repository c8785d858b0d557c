"""Recordings and loggers' tables taken into the store."""
