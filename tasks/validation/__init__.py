"""How it is known that what is stated holds: examples, known truths, coverage, other programs."""
