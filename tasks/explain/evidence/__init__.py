"""What each selected effect earns, on seen and held-out segments, and the findings made of it."""
