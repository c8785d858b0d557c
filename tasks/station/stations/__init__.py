"""Complete station files to start from."""
