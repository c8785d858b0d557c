"""`mimucal remind`: what is due, which messages were sent, and the calendar of a client."""

import sys
from datetime import UTC, datetime, timedelta

from flows.terminal import print_json, print_rows
from schemas.base import BrokenOff
from storage.home import home
from tasks.stages import remind


def print_reminders(within: int, dry_run: bool, as_json: bool) -> None:
    """Send the reminders due now, unless `dry_run`, and list units due within so many days."""
    place, now = home(), datetime.now(UTC)
    faults = [] if dry_run else remind.remind(place, now)
    due = remind.due_units(place, now.astimezone().date() + timedelta(days=within))
    sent = remind.sent(place)
    if as_json:
        listed = [
            {"unit": each.unit, "certificate": each.certificate, "due": each.due.isoformat(),
             "sent": sent.get(each.certificate, [])}
            for each in due
        ]  # fmt: skip
        print_json({"format": "mimu-reminders/1", "due": listed})
    else:
        print_rows(
            f"Recalibration due within {within} days",
            ("unit", "client", "certificate", "due", "sent"),
            [
                (each.unit, each.client[0], each.certificate, each.due.isoformat(),
                 "; ".join(sent.get(each.certificate, [])))
                for each in due
            ],
        )  # fmt: skip
    if faults:
        raise BrokenOff(f"Not sent, and tried again by the next `mimucal remind`: "
                        f"{'; '.join(faults)}.")  # fmt: skip


def print_calendar(client: str) -> None:
    """Print the due dates of a client as a calendar (RFC 5545)."""
    sys.stdout.write(remind.feed(home(), client, datetime.now(UTC)).decode())
