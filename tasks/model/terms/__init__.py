"""The terms: each file adds one piece of physics or a small family."""
