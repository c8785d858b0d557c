"""Hostile calls of the pages and of the flows: none acts, and each is logged."""
