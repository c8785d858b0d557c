"""The operations pages: what `mimucal dashboard` serves.

A page is one module: a typed question (its query), the function that answers it from the store,
and the layout that shows the answer. `answers.py` lists them; from that list come the
navigation, the addresses, the JSON endpoints and their OpenAPI description.
"""
