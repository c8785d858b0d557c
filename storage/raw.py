"""Raw recordings: MCAP files, write-once, known by the digest of their content."""

from storage.content import as_raw, digest
from storage.raw_read import read_mcap
from storage.raw_write import RawWriter, write_mcap

__all__ = ["RawWriter", "as_raw", "digest", "read_mcap", "write_mcap"]
