"""The operations pages under what nobody asked for: random questions, a database that stops."""
