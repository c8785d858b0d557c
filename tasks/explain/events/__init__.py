"""Events: what happened to the readings at some time or level, found before any regression."""
