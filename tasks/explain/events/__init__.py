"""Events: artefacts of the readings that are no regressors, detected before and after a fit."""
