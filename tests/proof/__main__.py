"""`python -m tests.proof NAME`: a study from the command line (`make prove ARGS="NAME …"`)."""

import sys

from schemas.base import Unusable
from tests.surroundings import leave_production

UNUSABLE = 2

if __name__ == "__main__":
    leave_production()
    from tests.proof.studies import app  # late: processes that a study begins import this module

    try:
        app()
    except Unusable as refused:
        print(refused, file=sys.stderr)
        sys.exit(UNUSABLE)
