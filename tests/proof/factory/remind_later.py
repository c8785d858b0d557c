"""Sends the reminders that are due so many days from now: `… remind_later DAYS`; exit 1 on a fault.

A client is not reminded of a certificate just received, and two days are too short for the next
occasion: the clock of the reminders is put forward in their place.
"""

import sys
from datetime import UTC, datetime, timedelta

from storage.home import home
from tasks.stages.remind import remind

if __name__ == "__main__":
    faults = remind(home(), datetime.now(UTC) + timedelta(days=int(sys.argv[1])))
    print("; ".join(faults), file=sys.stderr)
    sys.exit(bool(faults))
