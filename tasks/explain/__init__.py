"""Where model and recording differ, which physics was left out, and how much it matters."""
