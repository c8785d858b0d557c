"""What each selected effect earns, also on held-out segments, and the findings made of it."""
