"""The terms: each file adds one effect or a small family of effects."""
