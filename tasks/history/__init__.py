"""What today's code makes of earlier recordings: differences between results, and their report."""
