"""What the operations pages show, one model for each page and its JSON."""
