"""Where the program's events go: with MIMUCAL_LOG=json a line of JSON each on standard error."""

import json
import logging
import sys
from datetime import UTC, datetime

from storage.environment import environment

# What every record has; the rest are the fields of the event.
COMMON = set(logging.makeLogRecord({}).__dict__) | {"message", "asctime"}


class JsonLine(logging.Formatter):
    """A record as one line of JSON: at (UTC), level, logger, event, then its own fields."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        fields = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name.removeprefix("mimucal."),
            "event": record.getMessage(),
        } | {name: value for name, value in record.__dict__.items() if name not in COMMON}
        if record.exc_info:
            fields["trace"] = self.formatException(record.exc_info)
        return json.dumps(fields, ensure_ascii=False, default=str)


def set_up() -> None:
    """Sends the events of this process where MIMUCAL_LOG says; without it nowhere.

    Raises Unusable for another value than json. Again, it changes nothing.
    """
    root = logging.getLogger("mimucal")
    if any(isinstance(each.formatter, JsonLine) for each in root.handlers):
        return
    if environment().log is None:
        return
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLine())
    root.addHandler(handler)
    root.setLevel(logging.INFO)
    root.propagate = False  # under Prefect its handlers would write them once more
