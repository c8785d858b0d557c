"""What the environment of whoever starts tests, proof or measurements names is none of theirs.

`leave_production` is called before anything of the program runs: a database, store or home in
production stays as it is, whichever test forgets to name its own.
"""

import os

OF_THE_PROGRAM = ("MIMUCAL_", "PREFECT_")
OF_THE_TESTS = {"MIMUCAL_DCC_SCHEMA", "PREFECT_SERVER_ANALYTICS_ENABLED"}


def leave_production() -> None:
    """Removes from this process and its children what names a database, home, store or server."""
    for name in list(os.environ):
        if name.startswith(OF_THE_PROGRAM) and name not in OF_THE_TESTS:
            del os.environ[name]
