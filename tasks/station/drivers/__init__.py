"""Drivers of tables, chambers, fixtures and units."""
