"""`make prove ARGS="--kills N"`: acquisitions killed at random moments, and what is recovered."""
