"""Proof that omitted physics is found: a sealed trial anyone can run."""
