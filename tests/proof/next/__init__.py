"""Sealed cases that `explain` leaves open, and what `next` proposes for them."""
