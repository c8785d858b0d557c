"""Signing a certificate with the laboratory's key."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Signing:
    """The laboratory's key, ready to sign."""
