"""How many frames a second the acquisition takes: `make prove ARGS="--throughput SECONDS"`."""
