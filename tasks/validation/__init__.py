"""Shows that what is stated holds: worked examples, known truths, coverage, other programs."""
