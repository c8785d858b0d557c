"""The content of the operations pages: one model for each page and its JSON."""
