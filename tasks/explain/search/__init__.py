"""Which regressors are missing from the standard's model: candidates, scores, selection, refit."""
