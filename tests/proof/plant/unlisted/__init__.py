"""Laws of known kinds of behaviour in forms that no catalogue lists, by another hand."""
