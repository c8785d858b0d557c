"""Noise by frequency and whitened normal equations."""
