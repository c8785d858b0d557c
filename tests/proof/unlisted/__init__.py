"""What `explain` says of known kinds of behaviour in forms that nobody listed."""
