"""When model and recording differ: where, which physics was left out, and how much it matters."""
