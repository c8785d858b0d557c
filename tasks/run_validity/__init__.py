"""The run is judged before the unit: each check with its limit and its reason."""
