"""The content of the operations pages: the question and the answer of each, as in its JSON."""
