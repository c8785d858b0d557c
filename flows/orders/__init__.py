"""Production orders: read, signed, kept in each station's queue, and carried out."""
