"""Recordings and tables of loggers, imported into the store."""
