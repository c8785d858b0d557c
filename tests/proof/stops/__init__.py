"""`make prove ARGS="--stops N"`: stops at random moments, with each part down in turn."""
