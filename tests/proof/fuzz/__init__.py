"""Every parser of the station fed with damaged input: `make prove ARGS="--fuzz N"`."""
