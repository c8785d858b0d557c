"""What many runs show together: evidence that adds up, who carries it and since when."""
