"""How often `explain` gives a wrong name by chance, in the noise of real recordings."""
