"""Tables of other makers as servers that know their own protocol alone."""
