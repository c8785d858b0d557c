"""What many runs show together: pooled evidence, its carrier, and since when."""
