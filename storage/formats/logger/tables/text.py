"""Lines of text, with whatever separates their fields."""

from pathlib import Path

from storage.formats.logger.tables import TEXT, Lines, decoded

SUFFIXES = (".csv", ".tsv", TEXT, ".log", ".dat", ".lvm")


def read(path: Path) -> Lines:
    """The lines of a text in whatever encoding; raises Unusable for what is no text."""
    return Lines(decoded(path).splitlines())
