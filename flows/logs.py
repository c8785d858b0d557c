"""Where the program's events go: on standard error, as MIMUCAL_LOG and MIMUCAL_LOG_LEVEL say."""

import json
import logging
import sys
from datetime import UTC, datetime
from typing import Any

from storage.home import environment

# What every record has; the rest are the fields of the event.
COMMON = set(logging.makeLogRecord({}).__dict__) | {"message", "asctime"}
ROOT = "mimucal"


class JsonLine(logging.Formatter):
    """A record as one line of JSON: at (UTC), level, logger, event, then its own fields."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        fields = {
            "at": _utc(record),
            "level": record.levelname.lower(),
            "logger": record.name.removeprefix(f"{ROOT}."),
            "event": record.getMessage(),
        } | _own_fields(record)
        if record.exc_info:
            fields["trace"] = self.formatException(record.exc_info)
        return json.dumps(fields, ensure_ascii=False, default=str)


class TextLine(logging.Formatter):
    """The same for people: at, level, logger and event, then the fields as name=value."""

    def format(self, record: logging.LogRecord) -> str:
        """The line, with the trace of an exception below it."""
        values = _own_fields(record).items()
        fields = "".join(f" {name}={value}" for name, value in values if value not in (None, ""))
        name = record.name.removeprefix(f"{ROOT}.")
        line = f"{_utc(record)} {record.levelname} {name}: {record.getMessage()}{fields}"
        trace = f"\n{self.formatException(record.exc_info)}" if record.exc_info else ""
        return line + trace


def _utc(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")


def _own_fields(record: logging.LogRecord) -> dict[str, Any]:
    return {name: value for name, value in record.__dict__.items() if name not in COMMON}


def set_up(*, errors_at_least: bool = False) -> None:
    """Sends the events of this process where the environment says; without it nowhere.

    errors_at_least: without it errors as text, as of a service whose operator sees nothing else.
    Raises Unusable for a value that neither variable has. Again, it changes nothing.
    """
    root = logging.getLogger(ROOT)
    if any(isinstance(each.formatter, JsonLine | TextLine) for each in root.handlers):
        return
    form, level = environment().log, environment().log_level
    if form is None and level is None:
        if not errors_at_least:
            return
        level = "error"
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLine() if form == "json" else TextLine())
    root.addHandler(handler)
    root.setLevel((level or "info").upper())
    root.propagate = False  # under Prefect its handlers would write them once more
