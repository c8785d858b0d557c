"""Hand analysis of real recordings, by textbook means; shares no code with what explains them."""
