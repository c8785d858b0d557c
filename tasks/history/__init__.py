"""Earlier recordings re-processed with today's code: differences between results, and a report."""
