"""History at scale: many recordings made again, here and by a cluster that is disturbed."""
