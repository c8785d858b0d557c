"""Complete station files, to begin one's own with."""
