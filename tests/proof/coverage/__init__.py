"""Coverage of the stated uncertainties on tables unlike that of the validation."""
